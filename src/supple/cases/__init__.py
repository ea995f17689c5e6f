"""The case file: one file per section, its tables and their build; the case they describe, and its run."""

from supple.cases.case import Case
from supple.cases.read_case import read_case
from supple.cases.run_case import CaseResult, run_case

__all__ = ["Case", "CaseResult", "read_case", "run_case"]

"""The case file: one file per section, its tables and their build; the case they describe, and its run."""

from supple.cases.case import Case
from supple.cases.modes_case import campbell_case, modes_case
from supple.cases.read_case import read_case
from supple.cases.run_case import CaseResult, run_case
from supple.cases.static_case import StaticResult, static_case

__all__ = [
    "Case",
    "CaseResult",
    "StaticResult",
    "campbell_case",
    "modes_case",
    "read_case",
    "run_case",
    "static_case",
]

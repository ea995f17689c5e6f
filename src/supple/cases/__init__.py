"""The case file: one file per section, its tables and their build; the case they describe, and its run."""

from supple.cases.case import Case
from supple.cases.explicit.explicit_case import ExplicitCase
from supple.cases.explicit.read_explicit_case import is_explicit, read_explicit_case
from supple.cases.explicit.run_explicit_case import ExplicitResult, run_explicit_case
from supple.cases.modes_case import campbell_case, modes_case
from supple.cases.read_case import read_case
from supple.cases.run_case import CaseResult, run_case
from supple.cases.static_case import StaticResult, static_case

__all__ = [
    "Case",
    "CaseResult",
    "ExplicitCase",
    "ExplicitResult",
    "StaticResult",
    "campbell_case",
    "is_explicit",
    "modes_case",
    "read_case",
    "read_explicit_case",
    "run_case",
    "run_explicit_case",
    "static_case",
]

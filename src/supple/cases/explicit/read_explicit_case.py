"""From a TOML file to a checked explicit case: every mistake at once, each with its line and remedy."""

from __future__ import annotations

from pathlib import Path

from supple.arguments import checked_arguments
from supple.cases.explicit.explicit_case import ExplicitCase
from supple.cases.explicit.explicit_tables import ExplicitTables, broken_rules
from supple.cases.notify import Notify, silent
from supple.cases.read_case import checked_file, raw_tables
from supple.errors import CaseError

__all__ = ["is_explicit", "read_explicit_case"]


@checked_arguments
def read_explicit_case(path: str | Path, notify: Notify = silent) -> ExplicitCase:
    """Read and check the case file of an explicit run.

        case = read_explicit_case("impact.toml")
        solution = simulate_explicit(case.system, case.run, options=case.options)

    notify : hears of each long step when the parts of the case are built

    Raises
    ------
    CaseError   no such file, not TOML, or any number of mistakes: one line each, with line number and remedy
    """
    path = Path(path)
    text, tables, lines = checked_file(
        path, ExplicitTables, lambda raw: (raw, broken_rules(raw, path.parent))
    )
    return ExplicitCase(path, text, tables, lines, notify)


def is_explicit(path: str | Path) -> bool:
    """Whether a case file has parts instead of bodies; false of what cannot be read."""
    try:
        _, raw = raw_tables(Path(path))
    except CaseError:
        return False
    return "part" in raw and "body" not in raw

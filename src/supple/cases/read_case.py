"""From a TOML file to a checked case: every mistake at once, each with its line and remedy."""

from __future__ import annotations

import tomllib
from pathlib import Path

from supple.cases.case import Case
from supple.cases.case_tables import CaseTables, broken_rules
from supple.cases.notify import Notify, silent
from supple.cases.reduced_file import with_interfaces_of_files
from supple.errors import CaseError
from supple.importers.toml import checked, index_lines, listed_mistakes


def read_case(path: str | Path, notify: Notify = silent) -> Case:
    """Read and check a case file.

        case = read_case("blade.toml")
        solution = simulate(case.system, case.run)

    notify : hears of each long step when the bodies of the case are built

    Raises
    ------
    CaseError   no such file, not TOML, or any number of mistakes: one line each, with line number and remedy
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise CaseError(f"cannot read the case file {path}: {error.strerror}; check the path") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path} is not a text file in UTF-8; is it a case file (.toml)?") from error
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(
            f"{path} is not valid TOML: {error}; strings need quotes, keys need a value"
        ) from error
    lines = index_lines(text)
    raw, mistakes = with_interfaces_of_files(raw, path.parent)
    mistakes += broken_rules(raw, path.parent)
    tables, mistakes = checked(CaseTables, raw, mistakes)
    if tables is None or mistakes:
        raise CaseError(listed_mistakes(path, lines, mistakes))
    return Case(path, text, tables, lines, notify)

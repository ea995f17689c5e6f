"""ASCII text files, written completely or not at all."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from supple.errors import ResultFileError
from supple.storage.atomic_write import replacing


def write_ascii(path: Path | str, lines: Iterable[str]) -> Path:
    """Write lines with a question mark for each character outside ASCII; returns the path.

    Raises ResultFileError: the file cannot be written.
    """
    target = Path(path)
    with replacing(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii", errors="replace")
    return target


def check_not_foreign(path: Path, mark: str) -> None:
    """ResultFileError if a file exists whose text lacks `mark`, which all files of this export contain.

    For files whose names the user does not give: an existing file may be a model.
    """
    if path.is_file() and mark not in path.read_text(encoding="utf-8", errors="replace"):
        raise ResultFileError(
            f"cannot write {path}: the file exists, was not written by this export and would be lost; write "
            "to another folder or file name"
        )

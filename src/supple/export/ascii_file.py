"""ASCII text files, written completely or not at all."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from supple.storage.atomic_write import replacing

__all__ = ["write_ascii"]


def write_ascii(path: Path | str, lines: Iterable[str]) -> Path:
    """Write lines with a question mark for each character outside ASCII; returns the path.

    Raises ResultFileError: the file cannot be written.
    """
    target = Path(path)
    with replacing(target) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii", errors="replace")
    return target

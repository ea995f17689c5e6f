"""Attempts at a share that came to no end: a process that is killed leaves its mark."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Sequence
from pathlib import Path

from supple.errors import MemoryShortageError, MissingPackageError, ResultFileError
from supple.storage.file_errors import file_errors

__all__ = ["NOT_OF_A_CASE", "Attempts"]

NOT_OF_A_CASE = (MemoryShortageError, MissingPackageError, ResultFileError)
"""Errors of the machine or the disk: another try may succeed, so nothing is recorded."""

MOST = 2
"""Attempts that may end with their process before a share is looked into case by case."""


class Attempts:
    """Marks of the attempts at a share, one file for each, which the end of the share removes.

    folder : of the sweep
    """

    def __init__(self, folder: Path, share: int) -> None:
        self._folder, self._share = folder / "attempts", share
        self._own: Path | None = None

    @property
    def marks(self) -> list[Path]:
        """Of all attempts that have not ended well."""
        return sorted(self._folder.glob(f"{self._share:05}-*.json"))

    @property
    def are_many(self) -> bool:
        """Whether processes have ended with this share twice."""
        return len(self.marks) >= MOST

    def begin(self, cases: Sequence[int]) -> None:
        """Note that this process marches some cases from now on."""
        with file_errors("write", self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._own is None:
                self._own = (
                    self._folder
                    / f"{self._share:05}-{socket.gethostname()}-{os.getpid()}-{len(self.marks)}.json"
                )
            self._own.write_text(json.dumps({"cases": [int(min(cases)), int(max(cases))]}), encoding="utf-8")

    def end(self) -> None:
        """The share has its part: all its marks go."""
        for mark in self.marks:
            mark.unlink(missing_ok=True)

    def withdraw(self) -> None:
        """The attempt ended without the process: its mark goes."""
        if self._own is not None:
            self._own.unlink(missing_ok=True)

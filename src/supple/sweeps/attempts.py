"""Records of processes that started a share of a sweep and did not finish it."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Sequence
from pathlib import Path

from supple.errors import MemoryShortageError, MissingPackageError, ResultFileError
from supple.storage.file_errors import file_errors

NOT_OF_A_CASE = (MemoryShortageError, MissingPackageError, ResultFileError)
"""Errors of the computer or the disk; not recorded for the cases, because a later attempt may succeed."""

MOST = 2
"""Smallest number of unfinished attempts after which the cases of a share run in isolated processes."""


class Attempts:
    """Files that mark attempts to run a share, one per attempt, until the share is finished.

    folder : folder of the sweep, or of a certificate;  share : number of the share, 0 for a certificate
    """

    def __init__(self, folder: Path, share: int) -> None:
        self._folder, self._share = folder / "attempts", share
        self._own: Path | None = None

    @property
    def marks(self) -> list[Path]:
        """Files of all attempts that are running or were killed."""
        return sorted(self._folder.glob(f"{self._share:05}-*.json"))

    @property
    def are_many(self) -> bool:
        """Whether at least `MOST` attempts are running or were killed."""
        return len(self.marks) >= MOST

    def begin(self, cases: Sequence[int]) -> None:
        """Record that this process starts to simulate some cases."""
        with file_errors("write", self._folder):
            self._folder.mkdir(parents=True, exist_ok=True)
            if self._own is None:
                self._own = (
                    self._folder
                    / f"{self._share:05}-{socket.gethostname()}-{os.getpid()}-{len(self.marks)}.json"
                )
            self._own.write_text(json.dumps({"cases": [int(min(cases)), int(max(cases))]}), encoding="utf-8")

    def end(self) -> None:
        """Remove all marks of the share, after its part is written."""
        for mark in self.marks:
            mark.unlink(missing_ok=True)

    def withdraw(self) -> None:
        """Remove the mark of this process, after its attempt ended with an exception."""
        if self._own is not None:
            self._own.unlink(missing_ok=True)

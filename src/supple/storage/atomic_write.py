"""Atomic file replacement: a file appears complete or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from supple.storage.file_errors import file_errors


@contextmanager
def replacing(path: Path | str) -> Iterator[Path]:
    """Path of a temporary file in the same folder, which replaces `path` when the block succeeds.

    A reader sees the old file or the complete new one. After an exception the old file is unchanged. A
    missing folder is created.

    Raises
    ------
    ResultFileError     the disk is full, the folder cannot be written, ...
    """
    target = Path(path)
    with file_errors("write", target):
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
        os.close(handle)
        temporary = Path(name)
        try:
            yield temporary
            # mkstemp creates a private file; a result gets the permissions of the user's other files.
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o666 & ~mask)
            with temporary.open("rb") as finished:
                os.fsync(finished.fileno())
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)

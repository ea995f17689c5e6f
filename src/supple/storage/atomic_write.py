"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from supple.storage.file_errors import file_errors


@contextmanager
def replacing(path: Path | str) -> Iterator[Path]:
    """Path of a temporary neighbour that takes the place of `path` when the block succeeds.

    A reader sees the old file or the new one, never half of either; an exception leaves the old file as it
    was. The folder is created where it is missing.

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
            # mkstemp keeps its file private; a result is as readable as any file its user makes.
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o666 & ~mask)
            with temporary.open("rb") as finished:
                os.fsync(finished.fileno())
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)

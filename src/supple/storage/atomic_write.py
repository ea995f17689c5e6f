"""Atomic file replacement, by which a file appears complete or not at all; reservation of disk space."""

from __future__ import annotations

import errno
import os
import shutil
import sys
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


def reserve_space(path: Path, size: int) -> None:
    """Reserve space so that an existing file can grow to `size` bytes; its length may then be `size`.

    HDF5 does not survive a failed write: the process crashes when it closes the file. Writing to reserved
    bytes cannot fail, neither for a full disk nor for a quota, so the space is reserved first. On other
    systems than Linux, only the free space of the disk is checked.

    Raises
    ------
    OSError     the disk is full, a quota or size limit is reached
    """
    if sys.platform == "linux":
        with path.open("r+b") as file:
            os.posix_fallocate(file.fileno(), 0, size)
    elif path.stat().st_size + shutil.disk_usage(path.parent).free < size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

"""Reservation of disk space before it is needed."""

from __future__ import annotations

import errno
import os
import shutil
import sys
from pathlib import Path


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

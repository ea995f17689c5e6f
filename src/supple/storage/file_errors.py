"""File errors as ResultFileError, with cause and remedy."""

from __future__ import annotations

import errno
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from supple.errors import ResultFileError

DAMAGE = (
    ArithmeticError,
    AttributeError,
    LookupError,
    MemoryError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)
"""Exceptions that reading a damaged file can raise, in any of the libraries involved."""

_REMEDIES = {
    errno.ENOSPC: "the disk is full: free some space or choose another disk",
    errno.EDQUOT: "the disk quota is used up: free some space or choose another disk",
    errno.EFBIG: "the file has reached the size limit of this file system or shell (ulimit -f): raise it",
    errno.EACCES: "permission denied: choose a folder you may write to",
    errno.EROFS: "the file system is read-only: choose another folder",
    errno.ENOENT: "no such file or folder: check the path",
    errno.EISDIR: "this is a folder: give the path of a file",
    errno.EEXIST: "a file has the name of the required folder: remove it, or choose another folder",
    errno.ENOTDIR: "a file has the name of a required folder: choose another folder",
    errno.ENAMETOOLONG: "the name is longer than this file system allows: choose a shorter one",
    errno.EAGAIN: "another process holds the file: wait for it to finish",
}


@contextmanager
def file_errors(action: str, path: Path, note: str = "") -> Iterator[None]:
    """Convert an error of the file system to a ResultFileError 'cannot <action> <path>: cause and remedy'.

    HDF5 reports the error number of the operating system in its message only, sometimes in a RuntimeError.
    """
    try:
        yield
    except ResultFileError:
        raise
    except (OSError, RuntimeError) as error:
        reason = _REMEDIES.get(_error_number(error), str(error))
        raise ResultFileError(f"cannot {action} {path}: {reason}{note}") from error


def _error_number(error: OSError | RuntimeError) -> int:
    buried = re.search(r"errno = (\d+)", str(error))
    return int(buried.group(1)) if buried else getattr(error, "errno", None) or 0

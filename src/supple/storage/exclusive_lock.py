"""Exclusive lock: one writer at a time for a file, or for a folder.

The operating system locks a file: `.NAME.lock` beside a file, or `.supple.lock` in a folder. The lock ends
with the process, however it ends. The lock file of a killed run therefore blocks no later run.
"""

from __future__ import annotations

import errno
import os
import socket
import sys
import time
import warnings
from pathlib import Path
from typing import Self

from supple.errors import ResultFileError, UnlockedWarning
from supple.storage.file_errors import file_errors

_BUSY = {errno.EACCES, errno.EAGAIN, errno.EDEADLK}
_NO_LOCKS_HERE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_ATTEMPTS = 100
"""Largest number of attempts if other processes keep removing the lock file."""
_PATIENCE = 0.05
"""Seconds between two attempts at a lock that another process holds."""


class ExclusiveLock:
    """A lock, from creation until `release`, the end of a `with` block, or the end of the process.

    path : file to lock, which need not exist, or an existing folder
    wait : wait until another holder releases the lock

    Raises
    ------
    ResultFileError     the lock is taken, by this process or another, and `wait` is False; the folder cannot
                        be written

    Warns
    -----
    UnlockedWarning     a file system without locks, such as some network file systems
    """

    def __init__(self, path: Path, *, wait: bool = False) -> None:
        self._neighbour = path / ".supple.lock" if path.is_dir() else path.with_name(f".{path.name}.lock")
        self._descriptor: int | None = None
        with file_errors("lock", path):
            while (descriptor := self._acquired(path, wait=wait)) is None:
                time.sleep(_PATIENCE)
            self._descriptor = descriptor

    def release(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._descriptor is None:
            return
        # Removed while locked: a process that opened it meanwhile finds it missing and creates a new file.
        self._neighbour.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def __del__(self) -> None:
        self.release()

    def _acquired(self, path: Path, *, wait: bool) -> int | None:
        """Descriptor of the open lock file; None if another process holds the lock and `wait` is set."""
        for _ in range(_ATTEMPTS):
            descriptor = os.open(self._neighbour, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                _lock(descriptor)
            except OSError as error:
                holder = os.read(descriptor, 200).decode(errors="replace")
                os.close(descriptor)
                if error.errno in _BUSY and wait:
                    return None
                if error.errno in _BUSY:
                    raise ResultFileError(
                        f"cannot write {path}: another run is writing it"
                        f"{f' ({holder})' if holder else ''}; wait for its end, stop it, or write elsewhere"
                    ) from error
                if error.errno in _NO_LOCKS_HERE:
                    return self._without_lock(path)
                raise
            if is_at(os.fstat(descriptor), self._neighbour):
                os.truncate(descriptor, 0)
                os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
                return descriptor
            os.close(descriptor)  # the last holder removed the file after it was opened here
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    def _without_lock(self, path: Path) -> int:
        warnings.warn(
            f"the file system of {path} has no locks: make sure that no other run writes there",
            UnlockedWarning,
            stacklevel=4,
        )
        return os.open(self._neighbour, os.O_RDWR | os.O_CREAT, 0o666)


def is_at(file: os.stat_result, path: Path) -> bool:
    """Whether a file is still the one at a path."""
    try:
        return os.path.samestat(file, path.stat())
    except FileNotFoundError:
        return False


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        # A byte behind the text, so that the text stays readable.
        os.lseek(descriptor, 1 << 20, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

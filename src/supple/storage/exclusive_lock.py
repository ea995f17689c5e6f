"""Exclusive lock: one writer at a time for a file, or for a folder.

The lock is the operating system's, on a neighbour `.NAME.lock`. It ends with the process that holds it,
however that ends, so that a neighbour which a killed run left behind is in nobody's way.
"""

from __future__ import annotations

import errno
import os
import socket
import sys
import time
import warnings
from pathlib import Path
from types import TracebackType
from typing import Self

from supple.errors import ResultFileError, UnlockedWarning
from supple.storage.file_errors import file_errors

_BUSY = {errno.EACCES, errno.EAGAIN, errno.EDEADLK}
_NO_LOCKS_HERE = {errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL}
_ATTEMPTS = 100
_PATIENCE = 0.05
"""s between two looks at a lock that is waited for."""


class ExclusiveLock:
    """Held from when it is made until `release`, the end of a `with` block, or the end of the process.

    path : what is locked, a file that may not be there yet, or a folder that is
    wait : until whoever holds it lets go

    Raises
    ------
    ResultFileError     somebody else holds it, in this process or another; the folder cannot be written

    Warns
    -----
    UnlockedWarning     a file system without locks, such as some that are shared over a network
    """

    def __init__(self, path: Path, *, wait: bool = False) -> None:
        self._neighbour = path / ".supple.lock" if path.is_dir() else path.with_name(f".{path.name}.lock")
        self._descriptor: int | None = None
        with file_errors("lock", path):
            while (descriptor := self._acquired(path, wait=wait)) is None:
                time.sleep(_PATIENCE)
            self._descriptor = descriptor

    def release(self) -> None:
        """Let others in; nothing happens the second time."""
        if self._descriptor is None:
            return
        # Removed while it is held: whoever opened it meanwhile sees that it is gone, and makes a new one.
        self._neighbour.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()

    def __del__(self) -> None:
        self.release()

    def _acquired(self, path: Path, *, wait: bool) -> int | None:
        """The open file; None where another holds it and is waited for."""
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
            if _is_at(descriptor, self._neighbour):
                os.truncate(descriptor, 0)
                os.write(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode())
                return descriptor
            os.close(descriptor)  # its last holder removed it between our opening and our locking it
        raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    def _without_lock(self, path: Path) -> int:
        warnings.warn(
            f"the file system of {path} knows no locks: make sure yourself that no other run writes there",
            UnlockedWarning,
            stacklevel=4,
        )
        return os.open(self._neighbour, os.O_RDWR | os.O_CREAT, 0o666)


def _is_at(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        # A byte beyond the text, which stays readable.
        os.lseek(descriptor, 1 << 20, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

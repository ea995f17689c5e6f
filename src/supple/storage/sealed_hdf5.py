"""Sealed HDF5 files: written whole and renamed, read only where their seal is that of their bytes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from supple.errors import ResultFileError
from supple.storage.atomic_write import replacing
from supple.storage.file_errors import DAMAGE, file_errors
from supple.storage.file_seal import has_seal, is_seal_broken, sealed

__all__ = ["is_whole", "open_sealed", "writing_sealed"]


@contextmanager
def writing_sealed(path: Path) -> Iterator[h5py.File]:
    """A file in memory that takes the place of `path` with its seal when the block succeeds.

    HDF5 does not survive a write that fails, and a reader sees the old file or the new one. Of the size of
    memory at most. ResultFileError where it cannot be written.
    """
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    with replacing(path) as temporary, file_errors("write", path):
        temporary.write_bytes(sealed(image))


def is_whole(path: Path) -> bool:
    """Whether a file is there whose seal is that of its bytes."""
    try:
        return has_seal(path) and not is_seal_broken(path)
    except OSError:
        return False


@contextmanager
def open_sealed(path: Path, *, verify: bool = True) -> Iterator[h5py.File]:
    """A sealed file to read.

    verify : compare the seal with all bytes first; a file that was verified a moment ago needs it no more

    Raises
    ------
    ResultFileError     no such file, damaged, or not of this kind
    """
    with file_errors("read", path):
        if not path.is_file():
            raise ResultFileError(f"cannot read {path}: no such file; check the path")
    if verify and not is_whole(path):
        raise ResultFileError(f"{path} is damaged: its bytes are not those that were written")
    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except ResultFileError:
        raise
    except DAMAGE as error:
        raise ResultFileError(f"cannot read {path}: {error}") from error

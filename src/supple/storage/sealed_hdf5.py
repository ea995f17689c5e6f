"""Sealed HDF5 files: written in one piece and renamed, read only where the seal matches."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from supple.errors import ResultFileError
from supple.storage.atomic_write import replacing
from supple.storage.file_errors import DAMAGE, file_errors
from supple.storage.file_seal import seal_matches, sealed


@contextmanager
def writing_sealed(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file in memory that replaces `path`, with its seal, when the block succeeds.

    It is built in memory, because HDF5 does not survive a failed write; a reader sees either the old file or
    the new one. The file must fit in memory. Raises ResultFileError if it cannot be written.
    """
    with h5py.File("image", "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    with replacing(path) as temporary, file_errors("write", path):
        temporary.write_bytes(sealed(image))


def is_whole(path: Path) -> bool:
    """Whether a file exists whose seal matches its bytes."""
    try:
        return seal_matches(path) is True
    except OSError:
        return False


@contextmanager
def open_sealed(path: Path, *, verify: bool = True) -> Iterator[h5py.File]:
    """A sealed file to read.

    verify : compare the seal with all bytes first; not needed shortly after a previous check

    Raises
    ------
    ResultFileError     a missing file, a damaged file, or one of another kind
    """
    with file_errors("read", path):
        if not path.is_file():
            raise ResultFileError(f"cannot read {path}: no such file; check the path")
    if verify and not is_whole(path):
        raise ResultFileError(
            f"{path} is damaged: its bytes have changed since it was written; copy it again, or "
            "repeat the command that wrote it"
        )
    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except ResultFileError:
        raise
    except DAMAGE as error:
        raise ResultFileError(f"cannot read {path}: {error}") from error

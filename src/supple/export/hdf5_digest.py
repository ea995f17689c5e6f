"""Digest of an HDF5 file: what the checksums of its arrays leave open, so that no damage goes unseen."""

from __future__ import annotations

import hashlib
from typing import Any

import h5py
import numpy as np

DIGEST = "digest"
"""The attribute of the file that holds its digest."""


def digest_of(file: h5py.File) -> str:
    """SHA-256 over names, shapes, types and attributes of all parts, texts, and arrays without a checksum.

    Arrays with a checksum are not read again.
    """
    found = hashlib.sha256()

    def add(*words: Any) -> None:
        found.update(repr(words).encode())

    def visit(name: str, part: h5py.Group | h5py.Dataset) -> None:
        add(name)
        if isinstance(part, h5py.Dataset):
            add(part.shape, part.dtype.str)
            if part.dtype.hasobject:
                add(part.asstr()[()].tolist())
            elif not part.fletcher32:
                found.update(part[()].tobytes())
        for key in sorted(part.attrs):
            if key != DIGEST:
                value = np.asarray(part.attrs[key])
                add(key, value.dtype.str, value.tolist())

    visit("/", file)
    file.visititems(visit)
    return found.hexdigest()

"""Reduced bodies as HDF5 files: all data of a body for simulations, without its mesh.

Format "supple-reduced-body", version 2 (any HDF5 reader opens it):

    attributes   format             "supple-reduced-body"
                 version            2
                 name               of the body
                 frame              "mean-axis", or "nodal-fixed" with the attribute frame_interface
                 rotation_limit     rad
    gram, stiffness, damping, frequencies, nodes, nodal_basis
                 the arrays of ReducedBody; cubic, quartic, rotation_basis, damping_cubic and damping_quartic
                 where the body has them
    interfaces/<i>      i = 0, 1, ...: attributes name, cubic_turn; datasets position (3,), motion (6, r),
                        tied_nodes (k,), softness (3,)
    condensed           datasets fields (n_nodal, m), amplitudes (m, n2) and, since version 2, moments
                        (12, n2), where the body has them
    report              the fields of ReductionReport, as in hdf5_record

Numbers are stored unchanged, so that reading reproduces every bit. Arrays have a checksum, and the file as a
whole a seal behind its last byte (file_seal). A file without a seal, as another program writes it, is copied
first (copied_hdf5).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from supple.arguments import checked_arguments
from supple.body import Frame, MeanAxisFrame, NodalFixedFrame
from supple.copied_hdf5 import open_copied
from supple.errors import ModelError, ResultFileError
from supple.reduction import CondensedMotion, ReducedBody, ReductionReport
from supple.reduction.reduced_body import ReducedInterface
from supple.storage.file_errors import DAMAGE, file_errors
from supple.storage.file_seal import seal_matches
from supple.storage.hdf5_record import (
    read_array,
    read_group,
    read_number,
    read_record,
    store_array,
    store_record,
)
from supple.storage.sealed_hdf5 import writing_sealed

__all__ = ["holds_reduced_body", "read_interface_names", "read_reduced_body", "write_reduced_body"]

FORMAT = "supple-reduced-body"
VERSION = 2
"""2: the condensed motion has inertia, which files of version 1 do not contain."""

_ARRAYS = (
    "gram",
    "stiffness",
    "cubic",
    "quartic",
    "damping",
    "damping_cubic",
    "damping_quartic",
    "nodes",
    "nodal_basis",
    "rotation_basis",
    "frequencies",
)
_OPTIONAL = ("cubic", "quartic", "damping_cubic", "damping_quartic", "rotation_basis")


@checked_arguments
def write_reduced_body(path: Path | str, body: ReducedBody) -> Path:
    """Write a reduced body as an HDF5 file, atomically; returns the path.

    Raises
    ------
    ModelError          a user-defined frame, which the format does not include
    ResultFileError     the file cannot be written
    """
    with writing_sealed(Path(path)) as file:
        file.attrs.update({"format": FORMAT, "version": VERSION, "name": body.name})
        file.attrs.update(_frame_attributes(body))
        file.attrs["rotation_limit"] = body.rotation_limit
        for name in _ARRAYS:
            if getattr(body, name) is not None:
                store_array(file, name, getattr(body, name))
        for i, interface in enumerate(body.interfaces):
            store_record(file.create_group(f"interfaces/{i}"), interface)
        if body.condensed is not None:
            store_record(file.create_group("condensed"), body.condensed)
        store_record(file.create_group("report"), body.report)
    return Path(path)


@checked_arguments
def read_reduced_body(path: Path | str) -> ReducedBody:
    """The reduced body in a file, identical in every bit.

    Raises
    ------
    ResultFileError     a missing file, no reduced body, a newer version, a damaged file
    """
    with _open(Path(path)) as file:
        found: dict[str, Any] = {
            name: None if name in _OPTIONAL and name not in file else _finite(file, name) for name in _ARRAYS
        }
        if "condensed" in file:
            found["condensed"] = read_record(read_group(file, "condensed"), CondensedMotion)
        return ReducedBody(
            name=_text(file.attrs["name"]),
            frame=_frame(file.attrs),
            interfaces=tuple(_interface(group) for group in _interface_groups(file)),
            rotation_limit=read_number(file, "rotation_limit"),
            report=read_record(read_group(file, "report"), ReductionReport),
            **found,
        )


def read_interface_names(path: Path | str) -> tuple[str, ...]:
    """Names of the interfaces of the reduced body in a file; ResultFileError as for read_reduced_body."""
    with _open(Path(path), ("interfaces",)) as file:
        return tuple(_text(group.attrs["name"]) for group in _interface_groups(file))


def holds_reduced_body(path: Path | str) -> bool:
    """Whether a file is an HDF5 file marked as a reduced body, or one whose seal does not match."""
    path = Path(path)
    if not path.is_file() or not h5py.is_hdf5(path):
        return False
    try:
        seal = seal_matches(path)
        if seal is False:
            return True  # read_reduced_body reports the damage
        with _content(path, seal, ()) as file:
            return file.attrs.get("format") == FORMAT
    except DAMAGE:
        return False


@contextmanager
def _open(path: Path, parts: Collection[str] | None = None) -> Iterator[h5py.File]:
    """The file, or some of its parts, after a check of its format and version.

    ResultFileError for another format or version, and for damage found while the file is open.
    """
    with file_errors("read", path):
        if not path.is_file():
            raise ResultFileError(f"cannot read {path}: no such file; check the path")
    if not h5py.is_hdf5(path):
        raise ResultFileError(f"cannot read {path}: not an HDF5 file, so not a reduced body; check the path")
    with file_errors("read", path, note="; if it was copied, copy it again"):
        seal = seal_matches(path)
    try:
        if seal is False:
            raise ValueError("its bytes have changed since it was written")
        with _content(path, seal, parts) as file:
            _check_format(path, file.attrs)
            yield file
    except ResultFileError:
        raise
    # A wrong checksum is an OSError of HDF5, and a missing part a KeyError. Parts that do not fit each other,
    # or are not finite, raise the ModelError of the body itself.
    except DAMAGE as error:
        raise ResultFileError(
            f"{path} is damaged ({error}): copy it again, or reduce the body again"
        ) from error


def _content(
    path: Path, seal: bool | None, parts: Collection[str] | None
) -> AbstractContextManager[h5py.File]:
    """The content of a file with a valid seal, or without one; HDF5 itself may hang on a damaged file."""
    return h5py.File(path, "r", locking=False) if seal else open_copied(path, parts)


def _check_format(path: Path, attributes: h5py.AttributeManager) -> None:
    if attributes.get("format") != FORMAT:
        raise ResultFileError(
            f"{path} is an HDF5 file but not a reduced body of supple: check the path; "
            "`supple reduce` and write_reduced_body create such files"
        )
    version = int(str(attributes.get("version", 0)))
    if version < 1:
        raise ValueError(f"there is no format version {version}")
    if version > VERSION:
        raise ResultFileError(
            f"{path} has format version {version}, and this version of supple reads up to {VERSION}: "
            "use the version that wrote it, or a newer one"
        )


def _finite(group: h5py.Group, name: str) -> np.ndarray:
    array = read_array(group, name)
    if not np.isfinite(array).all():
        raise ValueError(f"{name} contains NaN or infinity")
    return array


def _interface(group: h5py.Group) -> ReducedInterface:
    for name in ("position", "motion"):
        _finite(group, name)
    return read_record(group, ReducedInterface)


def _interface_groups(file: h5py.File) -> list[h5py.Group]:
    if "interfaces" not in file:
        return []
    groups = read_group(file, "interfaces")
    return [read_group(groups, str(i)) for i in range(len(groups))]


def _frame_attributes(body: ReducedBody) -> dict[str, str]:
    match body.frame:
        case MeanAxisFrame():
            return {"frame": "mean-axis"}
        case NodalFixedFrame(interface=interface):
            return {"frame": "nodal-fixed", "frame_interface": interface}
        case other:
            raise ModelError(
                f"cannot write body '{body.name}': its frame is {type(other).__name__}; a file can "
                "contain only MeanAxisFrame and NodalFixedFrame: replace the body's frame by one of these"
            )


def _frame(attributes: h5py.AttributeManager) -> Frame:
    kind = _text(attributes["frame"])
    if kind == "mean-axis":
        return MeanAxisFrame()
    if kind == "nodal-fixed":
        return NodalFixedFrame(_text(attributes["frame_interface"]))
    raise KeyError(f"frame {kind!r} is unknown")


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is not a text")
    return value

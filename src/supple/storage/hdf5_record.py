"""Frozen dataclasses as HDF5 groups and back: arrays, numbers, texts, mappings of numbers, other records.

array                   dataset, with a checksum
number, text            attribute
texts                   dataset of texts
numbers                 attribute
names with numbers      group of attributes (a mapping)
record; records         group; group of groups 0, 1, ...
None                    nothing
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from types import NoneType
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_origin, get_type_hints

import h5py
import numpy as np

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Record = TypeVar("Record", bound="DataclassInstance")


def store_array(group: h5py.Group, name: str, array: np.ndarray) -> None:
    """Write an array with a checksum."""
    # HDF5 attaches checksums to blocks; empty arrays and scalars have no blocks.
    blocks = {"chunks": True, "fletcher32": True} if array.ndim and array.size else {}
    group.create_dataset(name, data=array, **blocks)


def read_array(group: h5py.Group, name: str) -> np.ndarray:
    """The array of real numbers with that name.

    KeyError where it is missing, TypeError where it has no real numbers, ValueError where its size exceeds
    the file, OSError where its checksum does not match.
    """
    found = dataset(group, name)
    check_fits(found)
    if found.dtype.kind not in "fiu":
        raise TypeError(f"{name} has type {found.dtype} instead of real numbers")
    return np.asarray(found[()])


def read_group(group: h5py.Group, name: str) -> h5py.Group:
    """The group with that name; KeyError where there is none."""
    found = group[name]
    if not isinstance(found, h5py.Group):
        raise KeyError(f"{name} is not a group")
    return found


def read_number(group: h5py.Group, name: str) -> float:
    """The number in an attribute; KeyError where there is none, TypeError where it is not a number."""
    return float(np.asarray(group.attrs[name]).item())


def dataset(group: h5py.Group, name: str) -> h5py.Dataset:
    """The dataset with that name; KeyError where there is none."""
    found = group[name]
    if not isinstance(found, h5py.Dataset):
        raise KeyError(f"{name} is not a dataset")
    return found


def check_fits(found: h5py.Dataset, n_rows: int | None = None) -> None:
    """Raise ValueError, before memory is allocated, where a dataset or one of its blocks exceeds the file.

    n_rows : number of rows that are read; by default all. Nothing is compressed.
    """
    shape = found.shape if n_rows is None else (n_rows, *found.shape[1:])
    size, claimed = found.file.id.get_filesize(), found.dtype.itemsize * math.prod(shape)
    if claimed and found.chunks is not None:
        claimed = max(claimed, found.dtype.itemsize * math.prod(found.chunks))
    if claimed > size:
        raise ValueError(f"{found.name} has {claimed} bytes, more than the {size} bytes of the file")


def store_record(group: h5py.Group, record: DataclassInstance) -> None:
    """Write the fields of a frozen dataclass; TypeError for a field of another kind than listed above."""
    for item in fields(record):
        _store(group, item.name, getattr(record, item.name))


def read_record(group: h5py.Group, kind: type[Record]) -> Record:
    """The record of that kind in a group.

    A field that is missing in the group takes its default (files of older versions). Unknown entries of the
    group are ignored. KeyError or TypeError where an entry does not fit the record.
    """
    hints = get_type_hints(kind)
    found = {}
    for item in fields(kind):
        if item.name in group or item.name in group.attrs:
            found[item.name] = _read(group, item.name, hints[item.name])
    return kind(**found)


def _store(group: h5py.Group, name: str, value: object) -> None:
    match value:
        case None:
            return
        case np.ndarray():
            store_array(group, name, value)
        case bool() | int() | float() | str() | np.generic():
            group.attrs[name] = value
        case Mapping():
            group.create_group(name).attrs.update(value)
        case tuple() if all(isinstance(item, str) for item in value):
            group.create_dataset(name, data=list(value), dtype=h5py.string_dtype())
        case tuple() if all(isinstance(item, int | float) for item in value):
            group.attrs[name] = value
        case tuple() if all(is_dataclass(item) for item in value):
            inner = group.create_group(name)
            for i, item in enumerate(value):
                store_record(inner.create_group(str(i)), item)
        case _ if is_dataclass(value) and not isinstance(value, type):
            store_record(group.create_group(name), value)
        case _:
            raise TypeError(f"{name} is a {type(value).__name__}, which a record cannot hold")


def _read(group: h5py.Group, name: str, hint: Any) -> Any:
    kind = _unless_none(hint)
    origin = get_origin(kind) or kind
    if origin is np.ndarray:
        return read_array(group, name)
    if origin is tuple:
        return _read_tuple(group, name, get_args(kind)[0])
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {key: np.asarray(value).item() for key, value in read_group(group, name).attrs.items()}
    if is_dataclass(origin):
        return read_record(read_group(group, name), origin)
    value = group.attrs[name]
    return value if isinstance(value, str) else origin(np.asarray(value).item())


def _read_tuple(group: h5py.Group, name: str, kind: Any) -> tuple[Any, ...]:
    found = group.get(name)
    if isinstance(found, h5py.Dataset):
        # An empty tuple has no type of items.
        check_fits(found)
        return tuple(found.asstr()[()])
    if is_dataclass(kind):
        inner = read_group(group, name)
        return tuple(read_record(read_group(inner, str(i)), kind) for i in range(len(inner)))
    return tuple(np.asarray(group.attrs[name]).tolist())


def _unless_none(hint: Any) -> Any:
    """The type X of a field annotated X | None; any other type unchanged."""
    parts = get_args(hint)
    return next(part for part in parts if part is not NoneType) if NoneType in parts else hint

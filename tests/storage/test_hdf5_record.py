"""Records of records come back from HDF5 as they were."""

from dataclasses import dataclass, replace

import h5py
import numpy as np
import pytest

from supple.storage.hdf5_record import read_record, store_record


@dataclass(frozen=True)
class Tried:
    size: int
    errors: np.ndarray
    note: str = "none"
    passed: bool = True


@dataclass(frozen=True)
class Nested:
    """What a report may hold one day."""

    tried: tuple[Tried, ...]
    best: Tried | None = None
    bounds: tuple[float, float] = (0.0, 1.0)
    nothing: tuple[Tried, ...] = ()
    missing: float | None = None


def test_records_within_records_are_kept(tmp_path, assert_same):
    steps = (Tried(3, np.array([0.1, np.inf])), Tried(5, np.empty(0), "last", passed=False))
    record = Nested(steps, steps[1], (-1.0, 2.5))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        store_record(file, record)
        assert_same(read_record(file, Nested), record)
        with pytest.raises(TypeError, match="best is a set, which a record cannot hold"):
            store_record(file.create_group("other"), replace(record, best={1}))

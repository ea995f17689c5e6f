"""Arrays come out of the deflated text as they went in, whatever their kind and place."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.report.packed_arrays import PackedArrays, unpacked


def test_arrays_come_back_in_any_order():
    rng = np.random.default_rng(3)
    given = [
        (rng.integers(-(2**15), 2**15, (4, 3, 5)), "i2"),
        (rng.standard_normal((7, 2)).astype(np.float32), "f4"),
        (rng.standard_normal((3, 4)), "f8"),
        (rng.integers(-(2**31), 2**31, 9), "i4"),
        (np.zeros((0, 3)), "f4"),
        (np.zeros((3, 0)), "i4"),
    ]
    arrays = PackedArrays()
    packings = [arrays.add(values, kind) for values, kind in given]
    text = arrays.text()
    for (values, _), packing in reversed(list(zip(given, packings, strict=True))):
        assert np.array_equal(unpacked(text, packing), values)
        assert unpacked(text, packing).shape == values.shape


@pytest.mark.parametrize("kind", ["i2", "i4"])
def test_numbers_that_vary_slowly_are_written_small(kind):
    smooth, rough = PackedArrays(), PackedArrays()
    values = np.rint(3e4 * np.sin(np.linspace(0, 3, 20000)))
    smooth.add(values, kind)
    rough.add(np.random.default_rng(0).permutation(values), kind)
    assert len(smooth.text()) < 0.15 * len(rough.text())


def test_a_number_that_does_not_fit_is_no_other_number():
    with pytest.raises(ModelError, match="up to 3000000000 in 32 bits"):
        PackedArrays().add(np.array([1, 3_000_000_000]), "i4")

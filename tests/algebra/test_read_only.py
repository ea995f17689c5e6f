from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import read_only


def test_a_private_copy_that_refuses_assignment():
    given = np.asfortranarray(np.arange(6).reshape(2, 3))
    held = read_only(given)
    given[0, 0] = 7
    assert held.dtype == np.float64
    assert held.flags.c_contiguous
    assert held[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        held[0, 0] = 1
    assert read_only([1, 2], np.int64).dtype == np.int64

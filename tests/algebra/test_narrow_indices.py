from __future__ import annotations

import numpy as np
from scipy import sparse

from supple.algebra.narrow_indices import narrow_indices


def test_indices_shrink_and_numbers_stay():
    entries = sparse.random_array((40, 30), density=0.2, rng=np.random.default_rng(0)).tocoo()
    wide = sparse.csc_array(
        (entries.data, (entries.row.astype(np.int64), entries.col.astype(np.int64))), shape=(40, 30)
    )
    assert wide.indices.dtype == np.int64
    narrow = narrow_indices(wide)
    assert narrow.indices.dtype == narrow.indptr.dtype == np.int32
    assert (narrow != wide).nnz == 0

"""Number of threads of BLAS and LAPACK.

Steps of reduced machines, and estimates of their errors, work with many matrices of ten to two hundred
columns. The threads of BLAS then wait for each other longer than they compute: a step with 73 unknowns took
5.6 ms with two threads and 3.0 ms with one. The error estimate for a blade took as long with one thread as
with two; two threads used 1.6 times the processor time.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

import scipy.linalg  # noqa: F401    loads the LAPACK of SciPy, which JAX calls; only then is it found
from threadpoolctl import ThreadpoolController


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Context, or decorator, in which BLAS and LAPACK use one thread."""
    with _libraries().limit(limits=1):
        yield


@lru_cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController().select(user_api="blas")

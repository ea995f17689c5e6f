"""Constraints between the freedoms of a body, eliminated: C q = 0 becomes q = T q_kept.

Each row of C eliminates one freedom: the dependent freedom named in the file if possible, another otherwise.
A row whose named freedom occurs in no other row is solved separately, so that T remains sparse for thousands
of nodes tied to surfaces. Other rows that share freedoms are solved together.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from supple.arrays import FloatArray, IntArray
from supple.body.massless_motion import StaticallyTied
from supple.errors import ModelError
from supple.fem import Constraints

# Entries of C below this fraction of the largest entry of their row are set to zero; entries of T likewise,
# relative to 1 or the largest entry.
_NOTHING = 1e-12
# A row whose pivot is below this fraction of the largest pivot depends on the others and is omitted. Rows are
# scaled to a largest entry of 1.
_REDUNDANT = 1e-9
# Pivot weights: freedoms named in the file are eliminated first, freedoms of interfaces last.
_NAMED, _LAST = 1e3, 1e-4
# Largest accepted residual of a row in a rigid motion, relative to the terms that cancel.
_RIGID = 1e-6


def eliminate(
    body: str,
    given: Constraints,
    expansion: sparse.csc_array,
    rigid_modes: FloatArray,
    last: NDArray[np.bool_],
    *,
    held: bool = False,
) -> StaticallyTied:
    """The numbers of the coordinates that remain after constraints, and the expansion from them to all q.

    given : constraints on the nodal freedoms u = expansion @ q;  rigid_modes : (n, 6) of q
    last : (n,) mask of coordinates that are eliminated only if no other coordinate can be
    held : whether the constraints may resist rigid motion of the body
    Raises ModelError for constraints that resist rigid motion of the body, unless `held`.
    """
    rows = sparse.csr_array(given.matrix @ expansion)
    n = expansion.indptr.size - 1
    largest = np.maximum(abs(rows).max(axis=1).toarray().ravel(), np.finfo(float).tiny)
    rows = sparse.csr_array(rows.multiply(1 / largest[:, None]))
    rows.data[np.abs(rows.data) < _NOTHING] = 0.0
    rows.eliminate_zeros()
    if not held:
        _check_free(body, given, rows, rigid_modes)
    rows, named = rows[np.diff(rows.indptr) > 0], _named(given, expansion)[np.diff(rows.indptr) > 0]

    uses = np.bincount(rows.indices, minlength=n)
    entry = np.zeros(len(named))
    known = np.flatnonzero(named >= 0)
    entry[known] = np.asarray(rows[known, named[known]]).ravel()
    alone = (named >= 0) & (np.abs(entry) > _REDUNDANT) & (uses[named] == 1)
    first = together(rows[~alone], named[~alone], last)
    own, dependents = rows[alone], named[alone]
    kept = np.setdiff1d(first.kept, dependents)
    T = sparse.csc_array(first.expansion[:, np.searchsorted(first.kept, kept)])
    follow = -(own.multiply(1 / entry[alone][:, None]) @ T)
    place = sparse.csc_array(
        (np.ones(len(dependents)), (dependents, np.arange(len(dependents)))), shape=(n, len(dependents))
    )
    return StaticallyTied(kept, sparse.csc_array(T + place @ follow))


def _check_free(body: str, given: Constraints, rows: sparse.csr_array, rigid_modes: FloatArray) -> None:
    held = np.abs(rows @ rigid_modes)
    whole = abs(rows) @ np.abs(rigid_modes)
    ratio = np.divide(held, whole, out=np.zeros_like(held), where=whole > 0).max(axis=1, initial=0.0)
    bad = np.flatnonzero(ratio > _RIGID)
    if bad.size:
        raise ModelError(
            f"body '{body}': {given.labels[bad[0]]} (one of {bad.size}) resists rigid motion of the body, "
            f"by {ratio[bad[0]]:.1e} of its terms; a body must be free: correct the factors, or leave the "
            "constraint out and support the body by joints"
        )


def _named(given: Constraints, expansion: sparse.csc_array) -> IntArray:
    """For each row, the coordinate (m,) that alone determines its dependent freedom; -1 if there is none."""
    rows = sparse.csr_array(expansion)
    counts, wanted = np.diff(rows.indptr), given.dependent
    one = (wanted >= 0) & (counts[wanted] == 1)
    found = np.full(len(wanted), -1)
    found[one] = rows.indices[rows.indptr[wanted[one]]]
    return found


def together(rows: sparse.csr_array, named: IntArray, last: NDArray[np.bool_]) -> StaticallyTied:
    """The kept coordinates and the expansion T, from rows C q = 0 solved in groups that share freedoms.

    named : (m,) coordinate that each row eliminates by preference, or -1
    last : (n,) mask of coordinates that are eliminated only if no other coordinate can be
    """
    n = len(last)
    eliminated: list[IntArray] = []
    places: list[tuple[IntArray, IntArray, FloatArray]] = []
    for members in _groups(rows):
        own = rows[members]
        freedoms = np.unique(own.indices)
        dense = own[:, freedoms].toarray()
        liked = np.where(last[freedoms], _LAST, 1.0)
        liked[np.isin(freedoms, named[members])] *= _NAMED
        decomposed: tuple[Any, ...] = linalg.qr(dense * liked, mode="r", pivoting=True)
        factor, order = decomposed[0], decomposed[-1]
        sizes = np.abs(np.diag(factor))
        rank = int((sizes > _REDUNDANT * sizes[0]).sum())
        dependent, free = order[:rank], order[rank:]
        solved = -linalg.solve_triangular(factor[:rank, :rank], factor[:rank, rank:])
        solved *= liked[dependent][:, None] / liked[free]
        solved[np.abs(solved) < _NOTHING * max(np.abs(solved).max(initial=0.0), 1.0)] = 0.0
        i, j = np.nonzero(solved)
        eliminated.append(freedoms[dependent])
        places.append((freedoms[dependent][i], freedoms[free][j], solved[i, j]))
    gone = np.concatenate(eliminated) if eliminated else np.empty(0, dtype=np.int64)
    kept = np.setdiff1d(np.arange(n), gone)
    at = np.concatenate([kept, *(row for row, _, _ in places)])
    column = np.searchsorted(kept, np.concatenate([kept, *(source for _, source, _ in places)]))
    values = np.concatenate([np.ones(len(kept)), *(value for _, _, value in places)])
    return StaticallyTied(kept, sparse.csc_array((values, (at, column)), shape=(n, len(kept))))


def _groups(rows: sparse.csr_array) -> Iterator[IntArray]:
    """Row numbers (k,) of each group of rows that share freedoms, directly or through other rows."""
    if rows.indptr.size == 1:
        return
    shared = sparse.csr_array(abs(rows) @ abs(rows).T)
    _, group = connected_components(shared, directed=False)
    order = np.argsort(group, kind="stable")
    yield from np.split(order, np.flatnonzero(np.diff(group[order])) + 1)

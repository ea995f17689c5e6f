"""The coordinates q of a body with tied nodes: eliminations from the nodal freedoms u.

    u = T q,    T = T_rigid T_constraints T_fixed T_massless

T_rigid: six freedoms of a virtual node replace the freedoms of the nodes of a rigid piece. T_constraints:
each constraint eliminates one freedom. T_fixed: rotations without stiffness (of nodes of solids beside
shells) are fixed. T_massless: massless freedoms are condensed statically.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from supple.algebra import factorize_symmetric
from supple.algebra.narrow_indices import narrow_indices
from supple.arrays import FloatArray, IntArray
from supple.body.checks import FREEDOM_NAMES, freedom_label
from supple.body.constraints import eliminate, together
from supple.body.massless_motion import StaticallyTied, massless_motions, tie_statically
from supple.body.rigid_motion import nodal_rigid_modes
from supple.body.second_order_tie import RigidSet
from supple.errors import AccuracyError, ModelError
from supple.fem import Attached
from supple.summary import place_text

# A stiffness in a triple of freedoms counts as zero up to this fraction of the largest one in the triple.
_NO_STIFFNESS = 1e-10
# The terms of a stiffness cancel if their sum is up to this fraction of them.
_ROUND_OFF = 1e-12
# Largest number of entries of a dense static condensation (160 MB); a larger one raises ModelError.
_LARGEST_TIE = 2e7
# Largest number of freedoms without mass whose softest motion is computed, to name one of them in a message.
_MOST_DENSE = 2000

AS_RIGID_BODY = (
    "use a rigid body with its mass, centre and inertia; springs and bushings to nodes without mass are "
    "elements of the machine"
)
"""Remedy for a body that no motion strains."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates q of a body, and their expansion to its nodes.

    whole : csc (n_nodal + n_modal, n0)   u = whole @ q0; q0 contains the freedoms of free nodes, then of
        rigid pieces, in triples (translations or rotations), then modal coordinates
    rest : csc (n0, n)          q0 = rest @ q; None where q0 = q, as with rigid pieces only
    rigid_modes : (n, 6);  stiffness, mass : csc (n, n), T^T A T of the nodal matrix A
    freedoms : (n,) nodal freedom of each coordinate, for messages; modal coordinates follow the nodal ones
    sets : the rigid pieces
    n_modal : number of modal coordinates in q0
    bare : freedoms that have no mass and are condensed statically
    n_fixed : number of fixed rotations without stiffness
    """

    whole: sparse.csc_array = field(repr=False)
    rest: sparse.csc_array | None = field(repr=False)
    rigid_modes: FloatArray = field(repr=False)
    stiffness: sparse.csc_array = field(repr=False)
    mass: sparse.csc_array = field(repr=False)
    freedoms: IntArray = field(repr=False)
    sets: tuple[RigidSet, ...] = field(repr=False)
    n_modal: int = 0
    bare: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64), repr=False)
    n_fixed: int = 0

    @property
    def n_massless(self) -> int:
        """Number of statically condensed freedoms."""
        return len(self.bare)

    @property
    def expansion(self) -> sparse.csc_array:
        """T (n_nodal + n_modal, n) = whole @ rest."""
        return self.whole if self.rest is None else sparse.csc_array(self.whole @ self.rest)

    def last_coordinates(self, k: int) -> sparse.csr_array:
        """Map (k, n) from q to the last k coordinates of q0 in triples: those of the rigid interfaces."""
        rows = self._rows
        end = rows.indptr.size - 1 - self.n_modal
        return sparse.csr_array(rows[end - k : end])

    @property
    def threes(self) -> sparse.csr_array | None:
        """Map (n0 - n_modal, n) from q to the coordinates of q0 in triples; None where these equal q."""
        if self.rest is None and not self.n_modal:
            return None
        rows = self._rows
        return sparse.csr_array(rows[: rows.indptr.size - 1 - self.n_modal])

    def is_rigid(self, stiffness: sparse.csc_array) -> bool:
        """Whether no coordinate strains the body: the terms of its stiffness, nodal matrix, all cancel.

        Example: a mass on springs whose other ends have no mass.
        """
        terms = abs(self.expansion).power(2).T @ np.abs(stiffness.diagonal())
        return bool((np.abs(self.stiffness.diagonal()) <= _ROUND_OFF * terms).all())

    @property
    def _rows(self) -> sparse.csr_array:
        """Map (n0, n) from q to q0."""
        if self.rest is not None:
            return sparse.csr_array(self.rest)
        return sparse.csr_array(sparse.eye_array(self.whole.indptr.size - 1))

    def of(self, matrix: sparse.csc_array) -> sparse.csc_array:
        """T^T A T (n, n) of a nodal matrix A."""
        product = congruent(self.whole, matrix)
        return product if self.rest is None else congruent(self.rest, product)


def rigid_sets(
    body: str,
    n_nodes: int,
    interfaces: Sequence[tuple[str, IntArray, FloatArray]],
    attached: Attached,
) -> tuple[RigidSet, ...]:
    """Rigid sets (nodes, position of the reference node); those of interfaces last, in the given order.

    Rigid pieces and interfaces that share a node are merged.

    interfaces : (name, nodes, position) of rigid interfaces
    attached : the rigid pieces of the body
    Raises ModelError for two interfaces in one merged set.
    """
    given = [*interfaces, *((each.name, each.nodes, each.position) for each in attached.rigid)]
    if not attached.rigid:
        return tuple((nodes, position) for _, nodes, position in given)
    member = np.repeat(np.arange(len(given)), [len(nodes) for _, nodes, _ in given])
    node = np.concatenate([nodes for _, nodes, _ in given])
    links = sparse.coo_array(
        (np.ones(len(node)), (node, n_nodes + member)), shape=(n_nodes + len(given),) * 2
    )
    _, group = connected_components(links, directed=False)
    of_nodes, of_given = group[:n_nodes], group[n_nodes:]
    own, first = np.unique(of_given, return_index=True)  # interfaces come first
    k = len(interfaces)
    for number in range(k):
        leader = first[np.searchsorted(own, of_given[number])]
        if leader != number:
            raise ModelError(
                f"body '{body}': rigid ties join the interfaces '{given[leader][0]}' and "
                f"'{given[number][0]}'; keep one of them, and attach all joints to it"
            )
    order = [*first[first >= k], *first[first < k][np.argsort(first[first < k])]]
    return tuple((np.flatnonzero(of_nodes == of_given[each]), given[each][2]) for each in order)


def rigid_elimination(
    nodes: FloatArray, dofs_per_node: int, rigid_sets: Sequence[RigidSet]
) -> sparse.csc_array:
    """The sparse expansion T, u_nodal = T q, with six coordinates for each rigid set.

        q = (freedoms of the nodes outside the sets in nodal order, then (u_v, theta_v) of each set)
        u_a = u_v + theta_v x (x_a - x_v),   theta_a = theta_v

    nodes      : (N, 3)
    rigid_sets : (node numbers (k,), position of the virtual node (3,)) each; no node in two of them
    Returns csc (N * dofs_per_node, n): n = (free nodes) * dofs_per_node + 6 * (sets).
    Source: Wu et al. 2019, Appendix B.
    """
    free = np.ones(len(nodes), dtype=bool)
    for node_ids, _ in rigid_sets:
        free[node_ids] = False
    kept = np.flatnonzero(np.repeat(free, dofs_per_node))
    rows, columns, entries = [kept], [np.arange(kept.size)], [np.ones(kept.size)]
    n = kept.size
    for node_ids, position in rigid_sets:
        block = nodal_rigid_modes(nodes[node_ids] - position, dofs_per_node)
        dofs = (node_ids[:, None] * dofs_per_node + np.arange(dofs_per_node)).ravel()
        row, column = np.nonzero(block)
        rows.append(dofs[row])
        columns.append(n + column)
        entries.append(block[row, column])
        n += 6
    triplets = (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns)))
    return narrow_indices(sparse.csc_array(triplets, shape=(len(nodes) * dofs_per_node, n)))


def coordinates(
    body: str,
    nodes: FloatArray,
    dofs_per_node: int,
    stiffness: sparse.csc_array,
    mass: sparse.csc_array,
    sets: tuple[RigidSet, ...],
    attached: Attached,
    *,
    n_interfaces: int = 0,
    n_modal: int = 0,
    tolerance: float,
    held: bool = False,
    node_ids: IntArray | None = None,
) -> Coordinates:
    """The coordinates that remain after ties, constraints, fixed rotations and static condensation.

    n_interfaces : number of rigid interfaces, which are the last of `sets`; their coordinates are kept
    n_modal : number of modal coordinates, the last rows of the matrices; zero in rigid motions
    tolerance : eigenvalues of the mass matrix, scaled to a unit diagonal, count as zero up to this value
    held : whether constraints may resist rigid motion; displacements without stiffness are then fixed as well
    node_ids : (N,) labels of the nodes in messages; by default numbers from 0
    Raises ModelError for constraints that resist rigid motion, unless `held`; negative mass; a rigid
    interface with a motion without mass; motions with neither mass nor stiffness; too many massless freedoms.
    """
    whole = rigid_elimination(nodes, dofs_per_node, sets)
    if n_modal:
        whole = sparse.csc_array(sparse.block_diag([whole, sparse.eye_array(n_modal)], format="csc"))
    free = np.ones(len(nodes), dtype=bool)
    for members, _ in sets:
        free[members] = False
    places = np.array([position for _, position in sets]).reshape(-1, 3)
    R = np.vstack(
        [nodal_rigid_modes(nodes[free], dofs_per_node), nodal_rigid_modes(places, 6), np.zeros((n_modal, 6))]
    )
    d = np.arange(dofs_per_node)
    own = [(np.flatnonzero(free)[:, None] * dofs_per_node + d).ravel()]
    own += [members[0] * dofs_per_node + np.minimum(np.arange(6), dofs_per_node - 1) for members, _ in sets]
    freedoms = np.concatenate([*own, len(nodes) * dofs_per_node + np.arange(n_modal)])
    n0, n_threes = len(R), len(R) - n_modal
    last = (np.arange(n0) >= n_threes - 6 * n_interfaces) & (np.arange(n0) < n_threes)
    K, M = congruent(whole, stiffness), congruent(whole, mass)
    state = _State(K, M, R, np.arange(n0), None)
    if attached.constraints is not None:
        state = state.after(eliminate(body, attached.constraints, whole, R, last, held=held))
    turns = np.repeat(held | ~R[:n_threes].reshape(-1, 3, 6)[:, :, :3].any(axis=(1, 2)), 3)
    if n_threes == 6:  # a single grid: its rotations are those of the body
        turns[:] = False
    turns = np.concatenate([turns, np.zeros(n_modal, dtype=bool)])
    still = _without_stiffness(state.K, state.kept // 3, turns[state.kept] & ~last[state.kept])
    if still.nnz:
        # The rigid motions of the body have no component along the fixed directions.
        state = replace(state, R=state.R - still @ (still.T @ state.R)).after(_fixed(still))
    before = state.kept
    labels = np.arange(len(nodes)) if node_ids is None else node_ids
    bare = _bare(body, state.M, ~last[state.kept], freedoms[state.kept], dofs_per_node, labels)
    if bare.any():
        try:
            tied = _follow_statically(body, state.K, bare)
        except AccuracyError:
            loose = freedoms[state.kept[np.flatnonzero(bare)[_loosest(state.K, bare)]]]
            node, component = divmod(int(loose), dofs_per_node)
            one = "a modal coordinate"
            if node < len(nodes):
                place = place_text(nodes[node], float(abs(nodes).max()))
                one = f"{FREEDOM_NAMES[component]} of the node at {place}"
            raise ModelError(
                f"body '{body}': among its {np.count_nonzero(bare)} freedoms without mass are some without "
                f"stiffness relative to the others, such as {one}; give them mass, or tie them"
            ) from None
        state = state.after(tied, _condensed(state.K, tied), state.M[tied.kept][:, tied.kept])
    try:
        motions = massless_motions(state.M, tolerance) if len(state.kept) else np.zeros((0, 0))
        if motions.shape[1]:
            state = state.after(tie_statically(state.K, motions, ~last[state.kept]))
    except ModelError as error:
        raise ModelError(
            f"body '{body}': the mass matrix is not positive definite: {error}; the density must be "
            "positive everywhere"
        ) from None
    return Coordinates(
        *(whole, state.rest, state.R, state.K, state.M, freedoms[state.kept], sets, n_modal),
        bare=freedoms[np.setdiff1d(before, state.kept)],
        n_fixed=still.indptr.size - 1,
    )


@dataclass(frozen=True, eq=False)
class _State:
    """Matrices and rigid motions of the remaining coordinates.

    kept : numbers of the remaining coordinates in q0;  rest : map from them to q0, None for the identity
    """

    K: sparse.csc_array
    M: sparse.csc_array
    R: FloatArray
    kept: IntArray
    rest: sparse.csc_array | None

    def after(
        self, tied: StaticallyTied, K: sparse.csc_array | None = None, M: sparse.csc_array | None = None
    ) -> _State:
        """The state after an elimination; K, M : matrices after the elimination, if already known."""
        T = tied.expansion
        rest = T if self.rest is None else sparse.csc_array(self.rest @ T)
        K = congruent(T, self.K) if K is None else sparse.csc_array(K)
        M = congruent(T, self.M) if M is None else sparse.csc_array(M)
        return _State(K, M, self.R[tied.kept], self.kept[tied.kept], rest)


def congruent(T: sparse.csc_array, matrix: sparse.csc_array) -> sparse.csc_array:
    """T^T A T, made exactly symmetric."""
    product = T.T @ matrix @ T
    return sparse.csc_array(0.5 * (product + product.T))


def _without_stiffness(
    stiffness: sparse.csc_array, triplet: IntArray, eligible: NDArray[np.bool_]
) -> sparse.csc_array:
    """Orthonormal directions (n, k), each within one triple of freedoms, without stiffness.

    It is sufficient to test the 3 x 3 diagonal blocks: as K is positive semidefinite, a motion without strain
    energy has zero force on all freedoms.
    triplet : (n,) number of the triple of each freedom;  eligible : (n,) mask of the freedoms to test
    """
    n = len(triplet)
    if not eligible.any():
        return sparse.csc_array((n, 0))
    entries = sparse.coo_array(stiffness)
    i, j = entries.coords
    near = eligible[i] & eligible[j] & (triplet[i] == triplet[j])
    there = np.flatnonzero(eligible)
    numbers, own = np.unique(triplet[there], return_inverse=True)
    slot = np.zeros(n, dtype=np.int64)
    slot[there] = np.arange(len(there)) - np.searchsorted(own, own)
    number = np.zeros(n, dtype=np.int64)
    number[there] = own
    blocks = np.zeros((len(numbers), 3, 3))
    blocks[number[i[near]], slot[i[near]], slot[j[near]]] = entries.data[near]
    exists = np.zeros((len(numbers), 3), dtype=bool)
    exists[own, slot[there]] = True
    # A triple's freedoms that are not eligible get a stiffness, so that they are not found.
    size = np.trace(blocks, axis1=1, axis2=2)
    blocks[:, range(3), range(3)] += np.where(exists, 0.0, np.where(size > 0, size, 1.0)[:, None])
    values, vectors = np.linalg.eigh(blocks)
    none = (
        values <= _NO_STIFFNESS * np.maximum(np.where(exists.all(axis=1), values[:, 2], size), 0.0)[:, None]
    )
    block, which = np.nonzero(none)
    place = np.full((len(numbers), 3), -1)
    place[own, slot[there]] = there
    rows, entry = place[block], vectors[block, :, which]
    entry[np.abs(entry) < 1e-12] = 0.0
    column = np.repeat(np.arange(len(block)), 3)
    used = (rows.ravel() >= 0) & (entry.ravel() != 0)
    return sparse.csc_array((entry.ravel()[used], (rows.ravel()[used], column[used])), shape=(n, len(block)))


def _fixed(still: sparse.csc_array) -> StaticallyTied:
    """Elimination of the motions along directions (n, k), each by one freedom of its triple."""
    n, k = still.shape
    return together(sparse.csr_array(still.T), np.full(k, -1), np.zeros(n, dtype=bool))


def _bare(
    body: str,
    mass: sparse.csc_array,
    eligible: NDArray[np.bool_],
    freedoms: IntArray,
    dofs_per_node: int,
    labels: IntArray,
) -> NDArray[np.bool_]:
    """Mask (n,) of freedoms without mass; ModelError for a negative mass, or no mass where not `eligible`."""
    diagonal = mass.diagonal()
    bare = diagonal <= np.finfo(float).tiny
    wrong = np.flatnonzero((diagonal < 0) | (bare & ~eligible))
    if wrong.size:
        own = wrong[np.argmin(diagonal[wrong])]
        # An averaging interface would need no mass, but it would lack the deflection of such a node.
        remedy = (
            "mass cannot be negative"
            if diagonal[own] < 0
            else "a rigid interface needs mass and inertia in every motion: give its material a density, or "
            "its node a small mass with inertia. A spring or bushing that alone holds this node may instead "
            "be one of the machine, at an interface beyond it"
        )
        raise ModelError(
            f"body '{body}': {freedom_label(int(freedoms[own]), labels, dofs_per_node)} has the mass "
            f"{diagonal[own]:.3e} (one of {wrong.size}); {remedy}"
        )
    return bare


def _loosest(stiffness: sparse.csc_array, bare: NDArray[np.bool_]) -> int:
    """The freedom, among those without mass, that moves most in their softest motion."""
    own = np.flatnonzero(bare)
    K = sparse.csc_array(stiffness[own][:, own])
    scale = np.sqrt(np.maximum(K.diagonal(), np.finfo(float).tiny))
    if (K.diagonal() <= _NO_STIFFNESS * K.diagonal().max(initial=0.0)).any() or len(own) > _MOST_DENSE:
        return int(np.argmin(K.diagonal()))
    scaled = K.toarray() / scale[:, None] / scale
    return int(np.argmax(np.abs(np.linalg.eigh(scaled).eigenvectors[:, 0])))


def _follow_statically(body: str, stiffness: sparse.csc_array, bare: NDArray[np.bool_]) -> StaticallyTied:
    """Static condensation of the freedoms e without mass: K_ee u_e + K_ek u_k = 0 for the kept freedoms k.

    ModelError if all freedoms are massless or the condensation is too large; AccuracyError if K_ee is
    singular.
    """
    eliminated, kept = np.flatnonzero(bare), np.flatnonzero(~bare)
    beside = sparse.csc_array(stiffness[eliminated][:, kept])
    reached = np.flatnonzero(np.diff(beside.indptr))
    if not len(kept) or len(eliminated) * len(reached) > _LARGEST_TIE:
        raise ModelError(
            f"body '{body}': {len(eliminated)} of its {len(bare)} freedoms have no mass"
            + (", too many for static condensation" if len(kept) else "")
            + "; give its materials a density, or its nodes masses"
        )
    solved = factorize_symmetric(stiffness[eliminated][:, eliminated]).solve(beside[:, reached].toarray())
    solved = -np.asarray(solved).reshape(len(eliminated), len(reached))
    solved[np.abs(solved) < 1e-13 * np.abs(solved).max(initial=0.0)] = 0.0
    i, j = np.nonzero(solved)
    places = np.concatenate([kept, eliminated[i]]), np.concatenate([np.arange(len(kept)), reached[j]])
    values = np.concatenate([np.ones(len(kept)), solved[i, j]])
    return StaticallyTied(kept, sparse.csc_array((values, places), shape=(len(bare), len(kept))))


def _condensed(stiffness: sparse.csc_array, tied: StaticallyTied) -> sparse.csc_array:
    """K_kk + K_ke T_ek, equal to T^T K T for statically condensed freedoms e, at less cost."""
    product = sparse.csc_array(stiffness[tied.kept] @ tied.expansion)
    return sparse.csc_array(0.5 * (product + product.T))

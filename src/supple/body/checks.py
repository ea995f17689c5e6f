"""Requirements on the matrices of a flexible body, and the errors when they are violated."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from supple.algebra import GroundedFactor, factorize_symmetric, grounded_factor
from supple.errors import AccuracyError, ModelError

MatrixLike = ArrayLike | sparse.csc_array | sparse.csr_array | sparse.coo_array
"""A dense or sparse matrix."""

SYMMETRY = 1e-9
RIGID_NAMES = (
    *(f"translation along {axis}" for axis in "xyz"),
    *(f"rotation about {axis}" for axis in "xyz"),
)
FREEDOM_NAMES = ("ux", "uy", "uz", "rx", "ry", "rz")


def checked_nodal_matrix(
    body: str,
    what: str,
    matrix: MatrixLike,
    nodes: NDArray[np.float64],
    dofs_per_node: int,
    n_modal: int,
    labels: NDArray[np.int64],
) -> sparse.csc_array:
    """The nodal matrix as csc; ModelError for a wrong shape, NaN or infinite entries, or asymmetry.

    Entries a_ij and a_ji may differ by SYMMETRY times the largest entry.
    labels : (N,) ids of the nodes for messages
    """
    n_nodal = len(nodes) * dofs_per_node + n_modal
    result = sparse.csc_array(matrix, dtype=np.float64)
    if result.shape != (n_nodal, n_nodal):
        modal = f" and {n_modal} modal coordinates" if n_modal else ""
        raise ModelError(
            f"body '{body}': the {what} has shape {result.shape}, but {len(nodes)} nodes with "
            f"{dofs_per_node} freedoms each{modal} need ({n_nodal}, {n_nodal})"
        )
    if not np.all(np.isfinite(result.data)):
        entry = int(np.flatnonzero(~np.isfinite(result.data))[0])
        raise ModelError(
            f"body '{body}': the {what} has an entry that is not finite in the row of "
            f"{freedom_label(int(result.indices[entry]), labels, dofs_per_node)}"
        )
    largest = abs(result).max() if result.nnz else 0.0
    difference = abs(result - result.T).tocoo()
    if difference.nnz and difference.data.max() > SYMMETRY * largest:
        entry = int(np.argmax(difference.data))
        raise ModelError(
            f"body '{body}': the {what} is not symmetric: the two entries of "
            f"{freedom_label(int(difference.row[entry]), labels, dofs_per_node)} with "
            f"{freedom_label(int(difference.col[entry]), labels, dofs_per_node)} differ by "
            f"{difference.data[entry] / largest:.1e} of the largest entry"
        )
    return result


def check_nodes(body: str, nodes: NDArray[np.float64], node_ids: NDArray[np.int64] | None = None) -> None:
    """Raise ModelError unless `nodes` is an (N, 3) array of finite numbers.

    node_ids : (N,) ids of the nodes for the message; by default node numbers
    """
    if nodes.ndim != 2 or nodes.shape[1] != 3 or len(nodes) == 0:
        raise ModelError(f"body '{body}': nodes have shape {nodes.shape}; give (N, 3)")
    bad = np.flatnonzero(~np.all(np.isfinite(nodes), axis=1))
    if bad.size:
        called = bad[0] if node_ids is None else node_ids[bad[0]]
        raise ModelError(
            f"body '{body}': node {called} has the coordinates {nodes[bad[0]]}, which are not finite"
        )


def check_moves_rigidly(
    body: str,
    what: str,
    matrix: sparse.csc_array,
    rigid_modes: NDArray[np.float64],
    dofs_per_node: int,
    tolerance: float,
    labels: NDArray[np.int64],
) -> None:
    """Raise ModelError unless K R = 0 within a tolerance; for damping C R = 0.

    matrix, rigid_modes : rows of the nodal freedoms, then of the modal coordinates
    labels : (N,) ids of the nodes for the message
    tolerance : largest accepted `rigid_force_ratios`
    """
    ratio = rigid_force_ratios(matrix, rigid_modes)
    row, mode = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    if ratio[row, mode] > tolerance:
        raise ModelError(
            f"body '{body}': its {what} resists rigid motion: in {RIGID_NAMES[mode]}, forces that must "
            f"cancel sum to {ratio[row, mode]:.1e} of their terms (allowed {tolerance:.0e}), most at "
            f"{freedom_label(int(row), labels, dofs_per_node)}. A body must be free: leave supports "
            "out of its matrices and support it by joints; for matrices printed with few digits, raise "
            "rigid_tolerance"
        )


def rigid_force_ratios(stiffness: sparse.csc_array, rigid_modes: NDArray[np.float64]) -> NDArray[np.float64]:
    """|K R| (n, 6), relative to a bound on the sum of the forces that cancel in each row.

    The bound is sum_j sqrt(K_ii K_jj) |R_j| over the nonzero K_ij, as |K_ij| <= sqrt(K_ii K_jj) if K is
    positive semidefinite. The ratio is 0 where the bound is 0.
    """
    force = np.abs(stiffness @ rigid_modes)
    root = np.sqrt(np.maximum(stiffness.diagonal(), 0))[:, None]
    pattern = sparse.csc_array((np.ones(stiffness.nnz), stiffness.indices, stiffness.indptr), stiffness.shape)
    cancelled = root * (pattern @ (root * np.abs(rigid_modes)))
    return np.divide(force, cancelled, out=np.zeros_like(force), where=cancelled > 0)


def checked_grounded_stiffness(
    body: str, stiffness: sparse.csc_array, rigid_modes: NDArray[np.float64]
) -> GroundedFactor:
    """The factor of K on springs (`grounded_factor`); ModelError for a mechanism or negative strain energy.

    A mechanism is a motion without strain energy that is not one of the six rigid motions.
    """
    try:
        grounded = grounded_factor(stiffness, rigid_modes)
    except AccuracyError as error:
        raise ModelError(
            f"body '{body}' can move in more than six ways without strain: a mechanism, a freedom without "
            "stiffness, or a part attached to a single node: connect it, or give it stiffness"
        ) from error
    if grounded.factor.inertia.negative:
        raise ModelError(
            f"body '{body}': its stiffness has {grounded.factor.inertia.negative} negative eigenvalues; "
            "strain energy cannot be negative; check the source of the matrix"
        )
    return grounded


def check_dissipates(
    body: str, damping: sparse.csc_array, stiffness: sparse.csc_array, tolerance: float
) -> None:
    """Raise ModelError if the damping matrix has negative eigenvalues, which add energy to a motion.

    tolerance : accepted size of negative eigenvalues, relative to the largest entry, after division of the
        rows and columns by sqrt(K_ii), so that metres and radians have equal weight
    """
    K_ii = stiffness.diagonal()
    scale = sparse.diags_array(np.divide(1.0, np.sqrt(K_ii), out=np.zeros_like(K_ii), where=K_ii > 0))
    scaled = scale @ damping @ scale
    largest = abs(scaled).max() if scaled.nnz else 0.0
    if not largest:
        return
    shifted = scaled / largest + max(tolerance, SYMMETRY) * sparse.eye_array(len(K_ii))
    if negative := factorize_symmetric(shifted).inertia.negative:
        raise ModelError(
            f"body '{body}': its damping has {negative} negative eigenvalues, which add energy to motions; "
            "check the signs and the source of the matrix; for matrices printed with few digits, raise "
            "rigid_tolerance"
        )


def freedom_label(row: int, labels: NDArray[np.int64], dofs_per_node: int) -> str:
    """Node id and component of a row of a nodal matrix, or the number of a modal coordinate."""
    node, component = divmod(row, dofs_per_node)
    if node < len(labels):
        return f"node {labels[node]} {FREEDOM_NAMES[component]}"
    return f"modal coordinate {row - len(labels) * dofs_per_node + 1}"

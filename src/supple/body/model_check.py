"""Model check: whether an imported stiffness and mass are those of one free elastic body.

Each finding states the checked quantity, its value and, if needed, a remedy.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from enum import Enum, auto
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

from supple.algebra import lowest_modes
from supple.arrays import FloatArray
from supple.body.checks import RIGID_NAMES, SYMMETRY, MatrixLike, freedom_label, rigid_force_ratios
from supple.body.coordinates import AS_RIGID_BODY, Coordinates, coordinates, rigid_sets
from supple.body.free_body import RIGID_TOLERANCE, freed_boundary
from supple.body.labelled_superelement import NodalMatrices
from supple.body.mass_properties import MassProperties, mesh_mass_properties, rigid_mass_properties
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import AccuracyError, ModelError
from supple.fem import Attached, FiniteElementModel, consistent_mass
from supple.mesh import Mesh

__all__ = [
    "Finding",
    "ModelCheck",
    "Verdict",
    "check_elements",
    "check_model",
    "check_nodal_matrices",
    "stiff_cells",
]

LOWEST_FREQUENCIES = "lowest free frequencies"
"""Name of the finding that lists the lowest free frequencies, in cycles per unit of time."""

# Eigenvalues below this fraction of the highest computed eigenvalue count as zero. Those of rigid modes reach
# about 1e-9 of the highest, those of the lowest elastic modes of slender parts about 1e-4.
ZERO_MODE = 1e-6
# Largest accepted relative difference between the mass properties of the mass matrix and of the mesh, far
# above the quadrature error on curved cells. If the difference is larger, the model is refused.
MASS_AGREEMENT = 0.02
# Largest accepted relative difference between the masses along x, y, z in R^T M R, due to rounding of entries
# printed with few digits. If the difference is larger, the model is refused.
SAME_MASS = 1e-4
# Ranges of `wave_speed`, which is 2 to 6 times the speed of sound: 30 m/s (rubber) to 2e4 m/s; a thousand
# times as large in mm/s. Outside the first range units are doubtful (such as mm with ms); outside the second
# the model is refused, unless it has modal coordinates.
USUAL_SPEEDS = (30.0, 3e8)
POSSIBLE_SPEEDS = (0.3, 1e11)
# Units of kg with mm and MPa are within the first range, so the finding lists the values of steel to compare.
WAVES_IN_STEEL = "in steel some 2e4 m/s, 8e5 in/s, 2e7 mm/s by this measure"


class Verdict(Enum):
    """Consequence of a finding for the model."""

    OK = auto()
    DOUBTFUL = auto()
    REFUSED = auto()


@dataclass(frozen=True)
class Finding:
    """One result of a check: the quantity, its value, the verdict, and the remedy if not accepted."""

    what: str
    seen: str
    verdict: Verdict = Verdict.OK
    remedy: str = ""


_UNITS_UNKNOWN = Finding("units", "not checked: the model has springs and masses only")


@dataclass(frozen=True, eq=False)
class ModelCheck:
    """All findings; the model is accepted unless one of them has the verdict REFUSED.

    mass         : mass, centre and inertia from the mass matrix; zeros if the matrices are not finite
    rigid_energy : (6,) |r^T K r| / (r^T |diag K| r) of the six rigid motions r; zeros if not finite
    n_zero_modes : number of modes without strain energy, 6 for a free body; None if not computed
    frequencies  : of the lowest elastic modes of the free body, cycles per unit of time; () if not computed
    """

    findings: tuple[Finding, ...]
    mass: MassProperties
    rigid_energy: FloatArray = field(repr=False)
    n_zero_modes: int | None = None
    frequencies: tuple[float, ...] = ()

    @property
    def is_accepted(self) -> bool:
        """Whether no finding has the verdict REFUSED."""
        return all(finding.verdict is not Verdict.REFUSED for finding in self.findings)

    def raise_if_refused(self, name: str) -> None:
        """Raise ModelError if the model is refused, with all findings that refuse it and their remedies.

        name : name of the body, for the message
        """
        refused = [f for f in self.findings if f.verdict is Verdict.REFUSED]
        if refused:
            lines = "\n".join(f"  {f.what}: {f.seen}; {f.remedy}" for f in refused)
            raise ModelError(f"the model of body '{name}' cannot be used:\n{lines}")


def check_model(
    nodes: FloatArray,
    stiffness: MatrixLike,
    mass: MatrixLike,
    *,
    dofs_per_node: int,
    n_frequencies: int = 6,
    node_ids: NDArray[np.int64] | None = None,
    mesh_mass: MassProperties | None = None,
    rigid_tolerance: float = RIGID_TOLERANCE,
    attached: Attached | None = None,
) -> ModelCheck:
    """All findings on the nodal matrices of a body; errors are findings, except for wrong matrix sizes.

    nodes           : (N, 3)
    stiffness, mass : sparse (n, n), n >= N * dofs_per_node, node by node, then modal coordinates
    n_frequencies   : number of elastic modes to compute; 0 for a fast check without modes. No modes are
        computed if the symmetry, mass, ties or modal coordinates are refused
    node_ids        : (N,) labels of the nodes in findings; by default node numbers from 0
    mesh_mass       : mass properties of the mesh, to compare with those of the matrix; None: no comparison
    rigid_tolerance : largest |K R| relative to the forces that cancel in it; above it the model is refused
    attached        : rigid pieces and constraints between nodes
    Raises ModelError for matrices that are not square, differ in size, or are smaller than the nodes need.
    """
    K, M = sparse.csc_array(stiffness, dtype=np.float64), sparse.csc_array(mass, dtype=np.float64)
    _check_sizes(len(nodes) * dofs_per_node, K, M)
    if not (np.isfinite(K.data).all() and np.isfinite(M.data).all()):
        broken = Finding(
            "finite entries", "infinite, or not numbers", Verdict.REFUSED, "export the matrices again"
        )
        return ModelCheck((broken,), MassProperties(0.0, np.zeros(3), np.zeros((3, 3))), np.zeros(6))
    if not M.data.any():
        remedy = "export the mass matrix as well"
        if mesh_mass is not None:
            remedy = "give the materials a density, or add concentrated masses"
        massless = Finding("mass", "none", Verdict.REFUSED, remedy)
        return ModelCheck((massless,), MassProperties(0.0, np.zeros(3), np.zeros((3, 3))), np.zeros(6))
    n_nodal = len(nodes) * dofs_per_node
    R = np.zeros((K.indptr.size - 1, 6))
    R[:n_nodal] = nodal_rigid_modes(nodes, dofs_per_node)
    K, _ = freed_boundary(K, M, None, n_nodes=len(nodes), dofs_per_node=dofs_per_node)
    labels = np.arange(len(nodes)) if node_ids is None else node_ids
    model = _Model(nodes, dofs_per_node, K, M, R, labels, len(R) - n_nodal, rigid_tolerance)
    properties = rigid_mass_properties(M, nodes, dofs_per_node)
    made, tied_found = _coordinates(model, attached or Attached())
    findings = [
        _symmetry("stiffness", K),
        _symmetry("mass", M),
        *_mass(model, properties, mesh_mass),
        *tied_found,
        *_modal(model),
        _grounding(model),
        _units(model),
    ]
    energy = _rigid_energy(K, R)
    check = ModelCheck(tuple(findings), properties, energy)
    positive = all(f.verdict is not Verdict.REFUSED for f in findings[:-2])
    if n_frequencies == 0 or not positive or made is None:
        return check
    modes, n_zero, frequencies = _modes(model, n_frequencies, made)
    return ModelCheck((*findings, *modes), properties, energy, n_zero, frequencies)


class _Model(NamedTuple):
    """Matrices K and M (n, n) of nodes (N, 3) and modal coordinates, with R (n, 6), and labels (N,)."""

    nodes: FloatArray
    dofs_per_node: int
    K: sparse.csc_array
    M: sparse.csc_array
    R: FloatArray
    labels: NDArray[np.int64]
    n_modal: int
    tolerance: float

    def label(self, row: int) -> str:
        """Node id and component, or modal coordinate, of a row of the matrices."""
        return freedom_label(row, self.labels, self.dofs_per_node)


def check_elements(model: FiniteElementModel, *, n_frequencies: int = 6) -> ModelCheck:
    """Findings of `check_model` on a finite-element model, and on its mass and cell compatibility."""
    expected = mesh_mass_properties(model)
    if model.mass_of is not consistent_mass:
        # Lumped nodal masses have an additional inertia, of the order of mass times cell size squared.
        found = rigid_mass_properties(model.mass, model.mesh.nodes, model.dofs_per_node)
        expected = replace(expected, inertia=found.inertia)
    check = check_model(
        model.mesh.nodes,
        model.stiffness,
        model.mass,
        dofs_per_node=model.dofs_per_node,
        n_frequencies=n_frequencies,
        node_ids=model.mesh.node_ids,
        mesh_mass=expected,
        attached=model.attached,
    )
    findings = check.findings
    if not model.sections:  # springs and masses: no waves
        findings = tuple(_UNITS_UNKNOWN if each.what == _UNITS_UNKNOWN.what else each for each in findings)
    cells = [_cells_twice(model.mesh), *_middle_nodes(model.mesh), *_first_order(model)]
    return replace(check, findings=(*findings, *cells))


def stiff_cells(model: FiniteElementModel) -> dict[str, int]:
    """Numbers of solid cells that are too stiff in bending, by type: of first order, and more than others.

    A bar of 20 x 2 x 2 boxes: its first frequency is 29 % too high with TETRA4, 7 % with plain HEXA8; with 40
    x 4 x 4 boxes 8 % and 2 %. Incompatible modes (`Section.incompatible`) make HEXA8 exact in pure bending.
    """
    found: dict[str, int] = {}
    for section in model.sections:
        kind = section.cell_type
        if kind.dimension == 3 and kind.n_nodes == kind.n_corners and not section.has_incompatible_modes:
            found[kind.name] = found.get(kind.name, 0) + len(section.cells)
    solids = sum(len(section.cells) for section in model.sections if section.cell_type.dimension == 3)
    return found if 2 * sum(found.values()) > solids else {}


def check_nodal_matrices(
    matrices: NodalMatrices, *, n_frequencies: int = 6, rigid_tolerance: float | None = None
) -> ModelCheck:
    """Findings of `check_model` on the matrices of another program, and on its recovered points.

    rigid_tolerance : as for `check_model`; None: from the printed precision of the matrices
    """
    check = check_model(
        matrices.nodes,
        matrices.stiffness,
        matrices.mass,
        dofs_per_node=matrices.dofs_per_node,
        n_frequencies=n_frequencies,
        node_ids=matrices.node_ids,
        rigid_tolerance=matrices.rigid_tolerance if rigid_tolerance is None else rigid_tolerance,
    )
    return replace(check, findings=(*check.findings, *_points_inside(matrices)))


def _points_inside(matrices: NodalMatrices) -> Iterator[Finding]:
    """Finding on recovered interior points; none without both recovery and modal coordinates."""
    what = "points inside"
    if matrices.recovery is None:
        if len(matrices.modal):
            yield Finding(
                what, "none: pictures and sensors have only the boundary; a recovery matrix adds points"
            )
        return
    n = matrices.stiffness.indptr.size - 1
    try:
        matrices.recovery.check("model", matrices.nodes, matrices.dofs_per_node, n)
    except ModelError as error:
        seen, _, remedy = str(error).removeprefix("body 'model': ").partition("; ")
        yield Finding(what, seen, Verdict.REFUSED, remedy)
        return
    yield Finding(what, f"{len(matrices.recovery.points)}, which move rigidly with the boundary")


def _cells_twice(mesh: Mesh) -> Finding:
    """Finding on cells with identical nodes: intended shells or beams in parallel, or a part given twice."""
    for kind, cells in mesh.cells.items():
        _, first, count = np.unique(np.sort(cells, axis=1), axis=0, return_index=True, return_counts=True)
        again = first[count > 1]
        if again.size:
            return Finding(
                "cells on the same nodes",
                f"{again.size} node groups with several {kind.name} cells, first at cell "
                f"{mesh.cell_ids[kind][again.min()]}",
                Verdict.DOUBTFUL,
                "their mass and stiffness add up; if a part is duplicated, remove the copy",
            )
    return Finding("cells on the same nodes", "none")


def _middle_nodes(mesh: Mesh) -> list[Finding]:
    """Finding on edges between linear and quadratic solids: linear cells do not follow the mid-side node."""
    linear, quadratic = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for kind, cells in mesh.cells.items():
        if kind.dimension < 3:
            continue
        ends = np.sort(cells[:, np.array(kind.edges)].reshape(-1, 2), axis=1)
        edges = ends[:, 0] * mesh.n_nodes + ends[:, 1]
        if kind.n_nodes > kind.n_corners:
            quadratic = np.union1d(quadratic, edges)
        else:
            linear = np.union1d(linear, edges)
    shared = np.intersect1d(linear, quadratic)
    if not shared.size:
        return []
    first, second = mesh.node_ids[list(divmod(int(shared[0]), mesh.n_nodes))]
    return [
        Finding(
            "linear cells on quadratic ones",
            f"{shared.size} edges with a mid-side node on one side only, first at nodes {first} and {second}",
            Verdict.DOUBTFUL,
            "the cells separate along these edges; give both sides mid-side nodes, or neither",
        )
    ]


def _first_order(model: FiniteElementModel) -> list[Finding]:
    """Finding on solid cells that are too stiff in bending."""
    found = stiff_cells(model)
    if not found:
        return []
    seen = ", ".join(f"{number} {name}" for name, number in found.items())
    remedy = (
        "mesh parts that bend with second-order cells, or with four cells through their thickness; for a "
        "mesh with a `solid` table, second_order = true adds the nodes of second-order cells"
    )
    return [Finding("solid cells of first order", f"{seen}: too stiff in bending", Verdict.DOUBTFUL, remedy)]


def _check_sizes(n: int, K: sparse.csc_array, M: sparse.csc_array) -> None:
    """Raise ModelError unless stiffness and mass are square, of equal size, and have at least n rows."""
    for what, matrix in (("stiffness", K), ("mass", M)):
        columns, rows = matrix.indptr.size - 1, matrix.tocsr().indptr.size - 1
        if rows != columns or rows < n or (what == "mass" and K.shape != M.shape):
            raise ModelError(
                f"the {what} has shape {matrix.shape}, but its nodes need ({n}, {n}), or more with modal "
                "coordinates, in both matrices; export both again"
            )


def _symmetry(what: str, matrix: sparse.csc_array) -> Finding:
    largest = float(abs(matrix.data).max(initial=0.0))
    difference = float(abs(matrix - matrix.T).max()) if matrix.nnz else 0.0
    relative = difference / largest if largest else np.inf
    if relative <= SYMMETRY:
        return Finding(f"symmetry of the {what}", f"{relative:.0e} of the largest entry")
    seen = f"differs from its transpose by {relative:.1e} of the largest entry" if largest else "all zero"
    return Finding(
        f"symmetry of the {what}",
        seen,
        Verdict.REFUSED,
        "export the structural matrix alone, whole, without gyroscopic, follower or control terms",
    )


def _mass(model: _Model, found: MassProperties, expected: MassProperties | None) -> list[Finding]:
    three = np.diag(model.R[:, :3].T @ (model.M @ model.R[:, :3]))
    spread = float(np.ptp(three) / max(abs(found.mass), np.finfo(float).tiny))
    if not found.mass > 0 or spread > SAME_MASS:
        masses = ", ".join(f"{value:.6g}" for value in three)
        boundary = (
            ", with the mass of the boundary freedoms and not of the modes alone" if model.n_modal else ""
        )
        total = Finding(
            "mass",
            f"{masses} along x, y, z",
            Verdict.REFUSED,
            f"a body has one positive mass; export the whole matrix{boundary if model.n_modal else ''}",
        )
    else:
        total = Finding("mass and centre", f"{found.mass:.6g} at {_point(found)}")
    moments = np.linalg.eigvalsh(found.inertia)
    inertia = Finding("principal inertia", ", ".join(f"{value:.4g}" for value in moments))
    if moments[0] < -1e-9 * abs(moments[-1]) or moments[-1] > (1 + 1e-6) * (moments[0] + moments[1]):
        inertia = Finding(
            inertia.what,
            inertia.seen,
            Verdict.REFUSED,
            "impossible for a mass distribution: use nodes and matrix of the same model, in the same units",
        )
    return [total, inertia] + ([] if expected is None else [_against_mesh(found, expected)])


def _against_mesh(found: MassProperties, expected: MassProperties) -> Finding:
    size = np.sqrt(np.trace(expected.inertia) / expected.mass)
    differences = (
        abs(found.mass - expected.mass) / expected.mass,
        float(np.linalg.norm(found.centre - expected.centre) / size),
        float(np.abs(found.inertia - expected.inertia).max() / np.abs(expected.inertia).max()),
    )
    seen = "mass {:.0e}, centre {:.0e}, inertia {:.0e}".format(*differences)
    if max(differences) <= MASS_AGREEMENT:
        return Finding("difference from the mesh", seen)
    return Finding(
        "difference from the mesh",
        seen,
        Verdict.REFUSED,
        f"density times volume of the mesh is {expected.mass:.6g}; check density, thickness and units",
    )


def _coordinates(model: _Model, beside: Attached) -> tuple[Coordinates | None, list[Finding]]:
    """The coordinates after ties and condensation, and findings on mass and ties; None if refused."""
    try:
        sets = rigid_sets("model", len(model.nodes), (), beside)
        made = coordinates(
            *("model", model.nodes, model.dofs_per_node, model.K, model.M, sets, beside),
            n_modal=model.n_modal,
            tolerance=model.tolerance,
            node_ids=model.labels,
        )
    except ModelError as error:
        remedy = (
            "every freedom needs mass, or stiffness by which it follows the others; give materials a "
            "density, or reduce massless rotations away (Nastran: ASET1,123)"
        )
        seen = str(error).removeprefix("body 'model': ")
        return None, [Finding("positive mass", seen, Verdict.REFUSED, remedy)]
    found = [_positive_mass(model, made)]
    if made.n_fixed:
        seen = f"{made.n_fixed}, which are fixed"
        found.append(Finding("rotations without stiffness", seen))
    if beside.rigid or beside.constraints is not None:
        rows = 0 if beside.constraints is None else len(beside.constraints.labels)
        found.append(Finding("ties within the body", f"{len(sets)} rigid pieces, {rows} constraints"))
    return made, found


def _positive_mass(model: _Model, made: Coordinates) -> Finding:
    """Finding on the mass: number and nodes of the massless motions, which are condensed statically."""
    labels, d, bare = model.labels, model.dofs_per_node, made.bare
    if not made.n_massless:
        return Finding("positive mass", f"all {len(made.freedoms)} eigenvalues")
    nodes = np.unique(labels[bare[bare < len(labels) * d] // d])
    listed = ", ".join(str(node) for node in nodes[:8]) + (", ..." if len(nodes) > 8 else "")
    return Finding(
        "positive mass",
        f"all but {made.n_massless} of {len(model.R)} eigenvalues; the motions without mass, at nodes "
        f"{listed}, follow the others statically",
    )


def _rigid_energy(K: sparse.csc_array, R: FloatArray) -> FloatArray:
    """|r^T K r| / (r^T |diag K| r) (6,) of each rigid motion r, with rotations about the mesh origin."""
    alone = np.einsum("ij,i,ij->j", R, np.abs(K.diagonal()), R)
    energy = np.einsum("ij,ij->j", R, K @ R)
    return np.divide(np.abs(energy), alone, out=np.zeros(6), where=alone > 0)


def _grounding(model: _Model) -> Finding:
    ratios = rigid_force_ratios(model.K, model.R)
    row, motion = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
    worst = float(ratios[row, motion])
    if worst <= model.tolerance:
        return Finding("free of supports", f"rigid-body residual {worst:.0e} of the forces that cancel")
    seen = (
        f"in {RIGID_NAMES[motion]}, forces that must cancel sum to {worst:.1e} of their terms, most at "
        f"{model.label(int(row))}"
    )
    factor = _unit_of_nodes(model)
    if factor is not None:
        return Finding(
            "free of supports",
            f"{seen}; all would cancel if the coordinates were {factor:.6g} times as large",
            Verdict.REFUSED,
            "nodes and matrices are in different units of length: use the same for both",
        )
    return Finding(
        "free of supports",
        seen,
        Verdict.REFUSED,
        "leave supports and springs to ground out of the model, and support it by joints; use the nodes "
        "of the matrix, in its axes (CD), and list modal coordinates on grids in QSET. "
        f"For entries printed with few digits, raise rigid_tolerance above {worst:.0e}",
    )


def _unit_of_nodes(model: _Model) -> float | None:
    """Factor on the node coordinates for which K R = 0; None if there is none, or without nodal rotations."""
    K, R = model.K, model.R
    if model.dofs_per_node == 3:
        return None
    turning = R.copy()
    turning[:, :3] = 0.0
    places = np.where(np.any(R[:, :3], axis=1)[:, None], turning, 0.0)
    weights = 1 / np.sqrt(np.where(K.diagonal() > 0, K.diagonal(), np.inf))[:, None]
    of_places, of_turns = (weights * (K @ part) for part in (places, turning - places))
    factor = -float(np.sum(of_places * of_turns) / max(np.sum(of_places**2), np.finfo(float).tiny))
    moved = np.hstack([R[:, :3], factor * places[:, 3:] + (turning - places)[:, 3:]])
    return factor if factor > 0 and rigid_force_ratios(K, moved).max() <= model.tolerance else None


def wave_speed(nodes: FloatArray, K: sparse.csc_array, M: sparse.csc_array, *, dofs_per_node: int) -> float:
    """Median node spacing times sqrt(median of K_ii / M_ii): about 2 to 6 times the speed of sound.

    The spacing is the distance to the nearest node; K_ii / M_ii is the largest of the translations of a node.
    Parameters as for `check_model`, without modal coordinates; at least two nodes.
    """
    rates = np.divide(
        K.diagonal(), M.diagonal(), out=np.zeros(len(nodes) * dofs_per_node), where=M.diagonal() > 0
    )
    fastest = rates.reshape(-1, dofs_per_node)[:, :3].max(axis=1)
    spacing = np.median(KDTree(nodes).query(nodes, k=2)[0][:, 1])
    return float(spacing * np.sqrt(max(float(np.median(fastest)), 0.0)))


def _units(model: _Model) -> Finding:
    if len(model.nodes) < 2:
        return Finding("units", "not checked: a single node has no size")
    n = len(model.nodes) * model.dofs_per_node
    own = model.K[:n, :n], model.M[:n, :n]
    speed = wave_speed(model.nodes, *own, dofs_per_node=model.dofs_per_node)
    extent = float(np.ptp(model.nodes, axis=0).max())
    seen = f"size {extent:.3g}, wave speed about {speed:.1e} per unit of time ({WAVES_IN_STEEL})"
    if USUAL_SPEEDS[0] <= speed <= USUAL_SPEEDS[1]:
        return Finding("units", seen)
    possible = POSSIBLE_SPEEDS[0] <= speed <= POSSIBLE_SPEEDS[1]
    return Finding(
        "units",
        seen,
        # The distance between boundary grids of a condensed model does not give the wave speed.
        Verdict.DOUBTFUL if possible or model.n_modal else Verdict.REFUSED,
        "use one consistent set: m, kg, s, Pa or mm, t, s, MPa",
    )


def _modal(model: _Model) -> Iterator[Finding]:
    """Finding on modal coordinates: angular velocities must be well below the lowest modal frequency."""
    if not (n_modal := model.n_modal):
        return
    k, m = model.K.diagonal()[-n_modal:], model.M.diagonal()[-n_modal:]
    rates = np.divide(k, m, out=np.full(n_modal, np.inf), where=m > 0)
    lowest = float(np.sqrt(max(rates.min(), 0.0)))
    if lowest <= 0:
        yield Finding(
            "modal coordinates",
            f"{n_modal}, number {int(np.argmin(rates)) + 1} without stiffness",
            Verdict.REFUSED,
            "modes of a clamped boundary all have stiffness: remove rigid body modes from the set, and list "
            "all boundary grids as kept",
        )
        return
    yield Finding(
        "modal coordinates",
        f"{n_modal}, from {lowest / (2 * np.pi):.4g} cycles per unit of time; matrices lack the direction "
        f"of their motion, so angular velocities should stay well below {lowest:.3g} rad per unit of time",
    )


def _modes(
    model: _Model, n_frequencies: int, made: Coordinates
) -> tuple[list[Finding], int | None, tuple[float, ...]]:
    wanted = min(6 + n_frequencies, len(made.freedoms))
    if made.is_rigid(model.K):
        rigid = Finding("lowest modes", "none: no motion strains the model", Verdict.REFUSED, AS_RIGID_BODY)
        return [rigid], None, ()
    try:
        pairs = lowest_modes(made.stiffness, made.mass, wanted)
    except (ModelError, AccuracyError) as error:
        remedy = (
            "strain energy cannot be negative; export the elastic stiffness, without loads or geometric terms"
        )
        return [Finding("lowest modes", str(error), Verdict.REFUSED, remedy)], None, ()
    zero = int(np.sum(pairs.values < ZERO_MODE * pairs.values[-1]))
    if zero == wanted or pairs.values[-1] <= 0:
        zero = wanted
    frequencies = tuple((np.sqrt(np.maximum(pairs.values[zero:], 0)) / (2 * np.pi)).tolist())
    rigid = made.expansion @ pairs.vectors[:, :zero]
    found = [_zero_modes(model, zero, rigid)]
    if frequencies:
        listed = ", ".join(f"{value:.4g}" for value in frequencies)
        found.append(Finding(LOWEST_FREQUENCIES, listed))
    return found, zero, frequencies


def _zero_modes(model: _Model, zero: int, vectors: FloatArray) -> Finding:
    what = "modes without energy"
    if zero == 6:
        return Finding(what, "6, as for a free body")
    if zero < 6:
        return Finding(what, f"{zero} of 6", Verdict.REFUSED, "the model is supported: remove its supports")
    R, loads = model.R, model.M @ model.R
    rest = vectors - R @ np.linalg.solve(R.T @ loads, loads.T @ vectors)
    row = int(np.argmax(np.abs(rest).max(axis=1)))
    return Finding(
        what,
        f"{zero} of 6; the further ones move most at {model.label(row)}",
        Verdict.REFUSED,
        "a mechanism, a freedom without stiffness or a loose part: connect it, or give it stiffness",
    )


def _point(found: MassProperties) -> str:
    """The centre of mass as text; components that are round-off relative to the body's size are 0."""
    size = np.sqrt(abs(np.trace(found.inertia)) / found.mass) if found.mass > 0 else 0.0
    centre = np.where(np.abs(found.centre) < 1e-9 * size, 0.0, found.centre)
    return "(" + ", ".join(f"{value:.4g}" for value in centre) + ")"

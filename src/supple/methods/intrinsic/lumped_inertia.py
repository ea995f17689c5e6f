"""Inertia of a body lumped on the stations of its line, with exact mass, first and second moments."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from supple.algebra import read_only
from supple.algebra.cross import cross_matrices
from supple.arrays import FloatArray
from supple.body.rigid_motion import nodal_rigid_modes
from supple.fem import CellMass, FiniteElementModel, cell_masses
from supple.mesh import CellType
from supple.methods.intrinsic.expansion import shares_of_stations
from supple.methods.intrinsic.load_path_tree import LoadPathTree

LARGEST = 0.45
"""Largest fraction by which arms are shortened; one half would leave beams without rotary inertia."""
SAFETY = 0.9
"""Fraction of a distance, or of a shortening of arms, at which a mass becomes singular."""
REACH = {1: 0.0, 2: 3**-0.5, 3: 0.5, 4: 5**-0.5, 5: 0.4, 6: 0.5, 8: 3**-0.5}
"""By number of corners of a cell: distance from the centre, relative to that of a corner, at which equal
masses have the second moments of the cell."""
_CORNERS = {1: 1} | {kind.n_nodes: kind.n_corners for kind in CellType}
"""Number of corners by number of nodes; a single node has a concentrated mass."""
ROUNDING = 1e-12
"""Mass and inertia relative to the largest; a smaller one is zero."""


def lumped_inertia(tree: LoadPathTree, model: FiniteElementModel) -> FloatArray:
    """Mass (n, 6, 6) of each station, for velocity and angular velocity there.

    The mass of a cell is divided into equal parts about points near its corners (`_parts`). Every part is
    attached to the two nearest stations, with weights that are linear along the segment, and with shorter
    arms (`with_shorter_arms`). No block is negative. Their sum equals the consistent mass of the elements in
    any rigid motion.

        M_i = sum_p w_ip (R_ip^T M_p R_ip - beta S_ip)

    w_ip are weights, M_p is the mass of part p, R_ip its rigid motion by that of station i, and S_ip as
    `arm_terms`.
    """
    rigid, change = np.zeros((tree.n, 6, 6)), np.zeros((tree.n, 6, 6))
    for mass in cell_masses(model):
        corners = model.mesh.nodes[mass.nodes]
        centres = corners.mean(axis=1)
        for points, part in _parts(mass, corners - centres[:, None]):
            stations, weights = shares_of_stations(tree, centres + points)
            feet = np.einsum("ea,eai->ei", weights, tree.points[stations])
            for end in range(2):
                at, weight = stations[:, end], weights[:, end, None, None]
                shift = nodal_rigid_modes(centres - tree.points[at], 6).reshape(-1, 6, 6)
                own = shift.swapaxes(1, 2) @ part @ shift
                np.add.at(rigid, at, weight * own)
                np.add.at(change, at, weight * arm_terms(own, feet - tree.points[at]))
    return with_shorter_arms(rigid, change, tree.mean_length)


def _parts(mass: CellMass, nodes: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Points (E, 3) and inertias (E, 6, 6) of equal parts of cells, about their centres.

    A part is a point mass between a corner and the centre, and an equal share of the remaining second moments
    of the cell. The points are `SAFETY` times as far from the centre as a positive remainder allows.

    nodes : (E, k, 3)   nodes of the cells, relative to the cells' centres
    """
    whole = _rigid_inertia(mass, nodes)
    n_corners = _CORNERS[nodes.shape[1]]
    corners = nodes[:, :n_corners] - nodes[:, :n_corners].mean(axis=1, keepdims=True)
    masses = whole[:, 0, 0] / n_corners
    middle = first_moments(whole) / np.where(whole[:, 0, 0], whole[:, 0, 0], 1.0)[:, None]
    points = middle[:, None] + SAFETY * REACH[n_corners] * corners
    modes = nodal_rigid_modes(points.reshape(-1, 3), 6).reshape(len(nodes), n_corners, 6, 6)[:, :, :3]
    concentrated = masses[:, None, None, None] * (modes.swapaxes(2, 3) @ modes)
    rest = (whole - concentrated.sum(axis=1)) / n_corners
    for corner in range(n_corners):
        yield points[:, corner], rest + concentrated[:, corner]


def arm_terms(inertia: FloatArray, along: FloatArray) -> FloatArray:
    """S (E, 6, 6): decrease of rigid inertias (E, 6, 6) at a station if arms are shortened, per unit beta.

    The first moments s become s - beta m d, the second moments P = integral of a a^T dm become
    P - beta (s d^T + d s^T).

    along : (E, 3)  d, vector from the station to the foot of each mass on its segment, the weighted mean of
                    the segment's ends
    """
    mass, first = inertia[:, 0, 0], first_moments(inertia)
    turned = cross_matrices(mass[:, None] * along)
    second = first[:, :, None] * along[:, None]
    second = second + second.swapaxes(1, 2)
    result = np.zeros((len(along), 6, 6))
    result[:, :3, 3:], result[:, 3:, :3] = -turned, turned
    result[:, 3:, 3:] = np.trace(second, axis1=1, axis2=2)[:, None, None] * np.eye(3) - second
    return result


def first_moments(masses: FloatArray) -> FloatArray:
    """First moments (n, 3) of rigid masses (n, 6, 6), or of their first three columns, about their points."""
    return masses[:, [5, 3, 4], [1, 2, 0]]


def with_shorter_arms(rigid: FloatArray, change: FloatArray, length: float) -> FloatArray:
    """Masses (n, 6, 6) of stations, `rigid` - beta `change`, with the largest beta that keeps them positive.

    Weights are linear along a segment. So sum w d = 0, and mass, first and second moments of the body do not
    depend on beta. With beta = 0, the weight q per length of a segment of length h causes moments q h^2 / 6
    on its stations. With beta = 1/2 the moments are q h^2 / 12, as at the ends of a clamped beam, and the
    line deflects as the beam does. A beam without rotary inertia allows beta = 0.37, because the inertia of
    its last half segment must stay positive.

    length : m, scale of inertias to masses
    """
    scale = np.repeat([1.0, 1.0 / length], 3)
    scaled, changed = (each * np.outer(scale, scale) for each in (rigid, change))
    largest = float(np.abs(scaled).max(initial=0.0))
    if not largest:
        return read_only(rigid)
    lower = np.linalg.cholesky(scaled + ROUNDING * largest * np.eye(6))
    half = np.linalg.solve(lower, changed)
    relative = np.linalg.solve(lower, half.swapaxes(1, 2))
    steepest = float(np.linalg.eigvalsh(0.5 * (relative + relative.swapaxes(1, 2))).max())
    beta = min(LARGEST, SAFETY / steepest) if steepest > 0 else LARGEST
    mass = rigid - beta * change
    return read_only(0.5 * (mass + mass.swapaxes(1, 2)))


def _rigid_inertia(mass: CellMass, arms: FloatArray) -> FloatArray:
    """R^T M_e R (E, 6, 6) of cells about points from which their nodes have arms (E, k, 3)."""
    m = mass.translational
    total = m.sum(axis=(1, 2))
    first = np.einsum("eab,ebi->ei", m, arms)
    second = np.einsum("eab,eai,ebj->eij", m, arms, arms, optimize=True)
    result = np.zeros((len(arms), 6, 6))
    eye = np.eye(3)
    result[:, :3, :3] = total[:, None, None] * eye
    result[:, :3, 3:] = -cross_matrices(first)
    result[:, 3:, :3] = cross_matrices(first)
    result[:, 3:, 3:] = np.trace(second, axis1=1, axis2=2)[:, None, None] * eye - second
    if mass.rotary is not None:
        result[:, 3:, 3:] += mass.rotary.sum(axis=(1, 2))[:, None, None] * eye
    if mass.coupled is not None:
        rigid = nodal_rigid_modes(arms.reshape(-1, 3), 6).reshape(len(arms), -1, 6)
        result += rigid.swapaxes(1, 2) @ mass.coupled @ rigid
    return result

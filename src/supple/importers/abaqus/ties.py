"""*TIE and tied contact: nodes of one surface follow the faces of another, matching or not."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from scipy.spatial import KDTree

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel, DeckSurface
from supple.importers.abaqus.element_types import Family
from supple.importers.freedom_sums import FreedomSums
from supple.importers.keyword_file import fields, numbers

_DEFAULT_TOLERANCE = 0.05
"""Distance, relative to `_face_size` of the master, up to which nodes are tied (CalculiX: 0.025)."""
_CANDIDATES = 16


def read_ties(model: AbaqusModel, rows: FreedomSums) -> None:
    """Rows  u_slave - sum_j N_j u_j = 0  for slave nodes within the tolerance of a master face.

    With TIED NSET, the slave nodes of this set are tied at any distance, and no others. A slave node is moved
    onto its face, the default of both programs, so that rigid motion causes no force. With ADJUST=NO, the
    default for surfaces of beams, nodes should stay; if one is moved, `left_out` contains the keyword.
    Between nodes of shells and beams, rotations are tied as well unless NO ROTATION is given. Cyclic and
    multistage ties are left out.

    Raises
    ------
    ImportFormatError   words instead of numbers
    """
    for placed in (*model.named("TIE"), *_tied_contacts(model)):
        block = placed.block
        if {"CYCLICSYMMETRY", "MULTISTAGE", "FLUIDPERIODIC"} & block.options.keys():
            model.report.leave_out_block(block, "the body is one sector, and its cuts are free")
            continue
        for line, text in block.data:
            names = [*fields(text), ""][:2]
            slave, master = (_surface(model, placed, name) for name in names)
            if slave is None or master is None or not master.faces or not len(slave.nodes):
                model.report.leave_out_block(block, f"surfaces '{names[0]}' and '{names[1]}' are not joined")
                continue
            _tie(model, placed, line, slave, master, rows)


def _tied_contacts(model: AbaqusModel) -> Iterator[ScopedBlock]:
    """*CONTACT PAIR with TIED, or with an interaction of PRESSURE-OVERCLOSURE=TIED (CalculiX)."""
    interaction, tied = "", set[str]()
    for placed in model.blocks:
        options = placed.block.options
        if placed.block.key == "SURFACEINTERACTION":
            interaction = options.get("NAME", "").upper()
        elif options.get("PRESSURE-OVERCLOSURE", "").upper() == "TIED":
            tied.add(interaction)
    for placed in model.blocks:
        options = placed.block.options
        if placed.block.key != "CONTACTPAIR" or placed.step:
            continue
        if "TIED" in options or options.get("INTERACTION", "").upper() in tied:
            model.report.read[placed.block.name] += 1
            yield placed


def _surface(model: AbaqusModel, placed: ScopedBlock, name: str) -> DeckSurface | None:
    """A surface, or a set of nodes of that name, as CalculiX allows."""
    found = model.surface(placed.scope, name)
    if found is None and (placed.scope, name.upper()) in model.node_sets:
        nodes = model.node_sets[placed.scope, name.upper()][1]
        found = DeckSurface(name, (nodes[:, None],), nodes)
    return found


def _tie(
    model: AbaqusModel,
    placed: ScopedBlock,
    line: int,
    slave: DeckSurface,
    master: DeckSurface,
    rows: FreedomSums,
) -> None:
    block, x = placed.block, model.positions
    nodes = slave.nodes[~np.isin(slave.nodes, master.nodes)]
    chosen = block.options.get("TIEDNSET")
    if chosen is not None:
        nodes = nodes[np.isin(nodes, model.nodes_of(placed.scope, chosen, block.line, f"*{block.name}"))]
    size = _face_size(x, master)
    tolerance = _DEFAULT_TOLERANCE * size if chosen is None else np.inf
    if "POSITIONTOLERANCE" in block.options:
        tolerance = numbers(model.file, block.line, [block.options["POSITIONTOLERANCE"]])[0]
    elif block.key == "CONTACTPAIR" and re.match(r"[.\d]", block.options.get("ADJUST", "")):  # no node set
        tolerance = max(tolerance, numbers(model.file, block.line, [block.options["ADJUST"]])[0])
    best = np.full(len(nodes), np.inf)
    where: list[tuple[IntArray, FloatArray]] = [(nodes[:0], np.empty(0))] * len(nodes)
    points = np.empty((len(nodes), 3))
    for faces in master.faces:
        found, shares, distances, places = _nearest(x, nodes, faces)
        closer = np.flatnonzero(distances < best)
        best[closer], points[closer] = distances[closer], places[closer]
        for i in closer.tolist():
            where[i] = faces[found[i]], shares[i]
    turning = model.nodes_of_families(Family.SHELL, Family.BEAM)
    if "NOROTATION" in block.options:
        turning[:] = False
    near = best <= tolerance + 1e-9 * size
    for i in np.flatnonzero(near).tolist():
        node, (face, shares) = int(nodes[i]), where[i]
        for component in range(6 if turning[node] and turning[face].all() else 3):
            terms = [(6 * node + component, 1.0)]
            terms += [(6 * int(j) + component, -float(N)) for j, N in zip(face, shares, strict=True)]
            rows.add(terms, model.file.numbers[line], dependent=6 * node + component)
    default = "NO" if slave.of_beams or master.of_beams else "YES"
    stays = block.key == "TIE" and block.options.get("ADJUST", default).upper() == "NO"
    if stays and best[near].max(initial=0.0) > 1e-6 * size:
        model.report.leave_out_block(
            block,
            f"nodes of '{slave.name}' are moved onto '{master.name}', by {best[near].max():.3g} or less",
        )
    model.positions[nodes[near]] = points[near]
    if not near.any() and (len(nodes) or chosen is not None):
        meaning = f"no node of '{slave.name}' lies within {tolerance:.3g} of '{master.name}'"
        if chosen is not None:
            meaning = f"set '{chosen}' has no node of '{slave.name}'"
        model.report.leave_out_block(block, meaning)
    elif not near.all():
        model.report.note(
            f"*{block.name} of '{slave.name}' to '{master.name}': {np.count_nonzero(~near)} of "
            f"{len(nodes)} nodes lie farther than {tolerance:.3g} from it and are not tied"
        )


def _face_size(x: FloatArray, surface: DeckSurface) -> float:
    """Mean distance of the first two corners of the faces; 1 for a surface of nodes."""
    spans = [
        np.linalg.norm(x[faces[:, 1]] - x[faces[:, 0]], axis=1)
        for faces in surface.faces
        if faces.shape[1] > 1
    ]
    return float(np.concatenate(spans).mean()) if spans else 1.0


def _nearest(
    x: FloatArray, nodes: IntArray, faces: IntArray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """For each node: index of the nearest face (F, k), shape functions, distance and position there."""
    centres = x[faces].mean(axis=1)
    count = min(_CANDIDATES, len(faces))
    _, candidates = KDTree(centres).query(x[nodes], k=count)
    # For positions that are not finite the query returns an index out of range.
    candidates = np.minimum(np.reshape(candidates, (len(nodes), count)), len(faces) - 1)
    pairs = faces[candidates].reshape(-1, faces.shape[1])
    targets = np.repeat(x[nodes], count, axis=0)
    shares = _projected(x[pairs], targets)
    places = np.einsum("pk,pki->pi", shares, x[pairs])
    distances = np.linalg.norm(places - targets, axis=1).reshape(-1, count)
    best = distances.argmin(axis=1)
    row = np.arange(len(nodes)) * count + best
    return candidates[np.arange(len(nodes)), best], shares[row], distances.ravel()[row], places[row]


def _projected(corners: FloatArray, targets: FloatArray) -> FloatArray:
    """Shape functions (P, k) at the points of faces (P, k, 3) nearest to the targets, by Gauss-Newton."""
    k = corners.shape[1]
    if k == 1:
        return np.ones((len(corners), 1))
    xi = np.full((len(corners), 2), 1 / 3 if k in (3, 6) else 0.0)
    for _ in range(20):
        N, dN = _shapes(k, xi)
        gap = targets - np.einsum("pk,pki->pi", N, corners)
        J = np.einsum("pka,pki->pia", dN, corners)
        normal = np.einsum("pia,pib->pab", J, J)
        # Edges have one parameter; the added unit fixes the second.
        normal[:, 1, 1] += np.where(normal[:, 1, 1] > 0, 0.0, 1.0)
        step = np.linalg.solve(
            normal + 1e-14 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(2),
            np.einsum("pia,pi->pa", J, gap)[..., None],
        )[..., 0]
        xi = _inside(k, xi + step)
        if np.abs(step).max(initial=0.0) < 1e-12:
            break
    return _shapes(k, xi)[0]


def _inside(k: int, xi: FloatArray) -> FloatArray:
    if k not in (3, 6):
        return np.clip(xi, -1.0, 1.0)
    xi = np.clip(xi, 0.0, 1.0)
    excess = np.maximum(xi.sum(axis=1) - 1, 0.0)
    return np.clip(xi - excess[:, None] / 2, 0.0, 1.0)


def _shapes(k: int, xi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (P, k) and derivatives: edge (2 nodes), triangle (3, 6) or quadrilateral (4, 8)."""
    r, s = xi.T
    zero, one = np.zeros_like(r), np.ones_like(r)
    if k == 2:
        N, dr, ds = [(1 - r) / 2, (1 + r) / 2], [-one / 2, one / 2], [zero, zero]
    elif k == 3:
        N, dr, ds = [1 - r - s, r, s], [-one, one, zero], [-one, zero, one]
    elif k == 6:
        t = 1 - r - s
        N = [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
        dr = [1 - 4 * t, 4 * r - 1, zero, 4 * (t - r), 4 * s, -4 * s]
        ds = [1 - 4 * t, zero, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
    else:
        corner_r, corner_s = np.array([-1, 1, 1, -1.0]), np.array([-1, -1, 1, 1.0])
        N, dr, ds = [], [], []
        for a, b in zip(corner_r, corner_s, strict=True):
            p, q = 1 + a * r, 1 + b * s
            if k == 4:
                N.append(p * q / 4)
                dr.append(a * q / 4)
                ds.append(b * p / 4)
            else:
                m = a * r + b * s - 1
                N.append(p * q * m / 4)
                dr.append(a * q * (m + p) / 4)
                ds.append(b * p * (m + q) / 4)
        if k == 8:
            for a, b in ((0, -1), (1, 0), (0, 1), (-1, 0)):
                if a == 0:
                    N.append((1 - r**2) * (1 + b * s) / 2)
                    dr.append(-r * (1 + b * s))
                    ds.append(b * (1 - r**2) / 2)
                else:
                    N.append((1 + a * r) * (1 - s**2) / 2)
                    dr.append(a * (1 - s**2) / 2)
                    ds.append(-s * (1 + a * r))
    return np.stack(N, axis=-1), np.stack([np.stack(dr, axis=-1), np.stack(ds, axis=-1)], axis=-1)

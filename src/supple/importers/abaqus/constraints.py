"""Multi-point constraints of Abaqus and CalculiX: equations, MPCs, rigid bodies and couplings."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel, DeckSurface
from supple.importers.abaqus.element_types import Family
from supple.importers.abaqus.freedoms import Freedoms, Rows, rigid_terms
from supple.importers.abaqus.mpc_rows import mpc_rows
from supple.importers.abaqus.orientation import Orientation
from supple.importers.abaqus.public_names import PublicIds
from supple.importers.deck import RigidTie, WeightedMean
from supple.importers.keyword_file import fields, numbers
from supple.importers.plain_number import is_plain_digits

_ALL = (1, 2, 3, 4, 5, 6)
_WHOLE = ({1, 2, 3}, {4, 5, 6}, {*_ALL})  # the same in all axes
_MPC_NODES = {"TIE": 2, "PIN": 2, "BEAM": 2, "LINK": 2, "LINEAR": 3, "SLIDER": 3, "QUADRATIC": 4}


@dataclass(eq=False)
class DeckConstraints:
    """Constraint rows, rigid ties and weighted means, collected while reading."""

    rows: Rows
    rigid: list[RigidTie] = field(default_factory=list)
    means: list[WeightedMean] = field(default_factory=list)


def read_constraints(
    model: AbaqusModel,
    freedoms: Freedoms,
    ids: PublicIds,
    orientations: Mapping[tuple[int, str], Orientation],
) -> DeckConstraints:
    """All constraints of a file except *TIE.

    Freedoms of kinematic couplings are in the axes of ORIENTATION at each node, else in global axes; those of
    *TRANSFORM have no effect on them, in Abaqus as in CalculiX. A node without rotations follows a rigid body
    or coupling in its translations only.

    Raises
    ------
    ImportFormatError   incomplete equations; words instead of numbers
    """
    found = DeckConstraints(Rows(freedoms.lines))
    solid_only = _nodes_of_solids_alone(model)
    for placed in model.named("RIGIDBODY"):
        _rigid_body(model, placed, freedoms, ids, found)
    for placed in model.named("EQUATION"):
        _equations(model, placed, freedoms, found.rows)
    for placed in model.named("MPC"):
        _mpcs(model, placed, freedoms, ids, found)
    coupling: ScopedBlock | None = None
    for placed in model.blocks:
        key = placed.block.key
        if placed.step or key not in ("COUPLING", "KINEMATIC", "DISTRIBUTING"):
            continue
        model.report.read[placed.block.name] += 1
        if key == "COUPLING":
            coupling = placed
        elif coupling is not None:
            _coupling(model, coupling, placed, freedoms, ids, found, solid_only, orientations)
    for placed in model.named("KINEMATICCOUPLING"):
        _kinematic_coupling(model, placed, freedoms, ids, found, solid_only, orientations)
    for placed in model.named("DISTRIBUTINGCOUPLING"):
        _distributing_coupling(model, placed, ids, found)
    return found


def _nodes_of_solids_alone(model: AbaqusModel) -> BoolArray:
    """Mask (N,) of nodes without rotations: elements use them, but no shell, beam or rotary inertia."""
    turns = np.zeros(len(model.positions), dtype=bool)
    used = np.zeros(len(model.positions), dtype=bool)
    for block in model.elements:
        used[block.nodes] = True
        if block.type.family in (Family.SHELL, Family.BEAM, Family.ROTARY_INERTIA):
            turns[block.nodes] = True
    return used & ~turns


# --- equations


def _equations(model: AbaqusModel, placed: ScopedBlock, freedoms: Freedoms, rows: Rows) -> None:
    file, block = model.file, placed.block
    data = list(block.data)
    i = 0
    while i < len(data):
        line, text = data[i]
        words = fields(text)
        if not is_plain_digits(words[0]) or len(words) > 1:
            raise file.error(line, f"*EQUATION begins with its number of terms; got '{text[:40]}'")
        wanted, found = int(words[0]), list[tuple[str, str, str]]()
        i += 1
        while i < len(data) and len(found) < wanted:
            row = [*fields(data[i][1]), "", ""]
            found += zip(row[0::3], row[1::3], row[2::3], strict=False)
            i += 1
        if len(found) != wanted or not wanted:
            raise file.error(line, f"an equation of {wanted} terms has {len(found)}; is the file cut short?")
        _equation(model, placed.scope, line, found, freedoms, rows)


def _equation(
    model: AbaqusModel,
    scope: int,
    line: int,
    terms: list[tuple[str, str, str]],
    freedoms: Freedoms,
    rows: Rows,
) -> None:
    """Add one equation, or one equation for each node of the sets in its terms."""
    nodes = [model.paired_nodes_of(scope, word, line, "*EQUATION") for word, _, _ in terms]
    count = max(len(each) for each in nodes)
    if any(len(each) not in (1, count) for each in nodes):
        model.report.leave_out("*EQUATION", line, "it names unknown nodes, or sets of different sizes")
        return
    factors = [numbers(model.file, line, [word])[0] for _, _, word in terms]
    components = [int(word) if is_plain_digits(word) else 0 for _, word, _ in terms]
    if not all(1 <= component <= 6 for component in components):
        model.report.leave_out("*EQUATION", line, "it names freedoms other than 1 to 6")
        return
    for k in range(count):
        row = []
        for each, component, factor in zip(nodes, components, factors, strict=True):
            row += freedoms.of(int(each[k if len(each) > 1 else 0]), component, factor)
        first = freedoms.of(int(nodes[0][k if len(nodes[0]) > 1 else 0]), components[0])
        dependent = first[0][0] if len(first) == 1 else -1
        rows.add(row, line, dependent=dependent)


# --- MPCs


def _mpcs(
    model: AbaqusModel, placed: ScopedBlock, freedoms: Freedoms, ids: PublicIds, found: DeckConstraints
) -> None:
    data = list(placed.block.data)
    i = 0
    while i < len(data):
        line, text = data[i]
        words = fields(text)
        kind = words[0].upper()
        i += 1
        # CalculiX continues after a comma with a line of more nodes, with or without a leading 0.
        while (
            i < len(data) and data[i - 1][1].rstrip().endswith(",") and is_plain_digits(fields(data[i][1])[0])
        ):
            words += fields(data[i][1])
            i += 1
        nodes = [model.paired_nodes_of(placed.scope, word, line, "*MPC") for word in words[1:] if word]
        groups = _groups(nodes, _MPC_NODES.get(kind, 0))
        if groups is None:
            model.report.leave_out(f"*MPC, {kind}", line, "its nodes are not tied")
            continue
        for first, *others in groups:
            if kind == "BEAM":
                (second,) = others
                _add_rigid(found, f"mpc_{ids.nodes[second]}", second, np.array([first]), line, freedoms)
            else:
                for terms, dependent in mpc_rows(kind, first, others, model.positions):
                    found.rows.add(terms, line, dependent=dependent)


def _groups(nodes: list[IntArray], n: int) -> list[list[int]] | None:
    """Groups of one node from each of n sets; a set of one node is in every group. None if sizes differ."""
    count = len(nodes[0]) if nodes else 0
    if not n or len(nodes) != n or any(len(each) not in (1, count) or not len(each) for each in nodes[1:]):
        return None
    return np.stack([np.broadcast_to(each, count) for each in nodes], axis=1).tolist()


# --- rigid bodies


def _add_rigid(
    found: DeckConstraints, name: str, reference: int, nodes: IntArray, line: int, freedoms: Freedoms
) -> None:
    """Add nodes to the rigid tie with this name and reference node, or make such a tie."""
    nodes = np.unique(nodes)
    nodes = nodes[nodes != reference]
    for i, other in enumerate(found.rigid):
        if other.name == name and other.reference == reference:
            joined = np.union1d(other.nodes, nodes)
            found.rigid[i] = RigidTie(name, reference, joined, other.line)
            return
    if len(nodes):
        found.rigid.append(RigidTie(name, reference, nodes, int(freedoms.lines[line])))


def _reference(model: AbaqusModel, placed: ScopedBlock) -> int | None:
    """The number of the node REF NODE; None if the option does not name exactly one node of the file."""
    word = placed.block.options.get("REFNODE", "")
    nodes = model.nodes_of(placed.scope, word, placed.block.line, f"*{placed.block.name}, REF NODE")
    if len(nodes) != 1:
        model.report.leave_out_block(
            placed.block, f"its reference node '{word}' is not exactly one node of the file"
        )
        return None
    return int(nodes[0])


def _rigid_body(
    model: AbaqusModel, placed: ScopedBlock, freedoms: Freedoms, ids: PublicIds, found: DeckConstraints
) -> None:
    block, scope = placed.block, placed.scope
    reference = _reference(model, placed)
    if reference is None:
        return
    if "".join(block.options.get("POSITION", "").upper().split()) == "CENTEROFMASS":
        model.report.leave_out_block(block, "its reference node is not moved to the centre of mass")
    tied, pinned = [], []
    what = f"*{block.name}"
    for option in ("NSET", "TIENSET"):
        if option in block.options:
            tied.append(model.nodes_of(scope, block.options[option], block.line, what))
    if "ELSET" in block.options:
        members = model.elements_of(scope, block.options["ELSET"], block.line, what)
        tied.append(model.nodes_of_elements(members))
    if "PINNSET" in block.options:
        pinned = model.nodes_of(scope, block.options["PINNSET"], block.line, what).tolist()
    if "ROTNODE" in block.options:
        for node in model.nodes_of(scope, block.options["ROTNODE"], block.line, what).tolist():
            freedoms.rotation_nodes[node] = reference
    if not tied and not pinned:
        model.report.leave_out_block(block, "its analytical surface is not tied to anything")
        return
    nodes = np.concatenate([np.empty(0, dtype=np.int64), *tied])
    if not len(nodes) and not pinned:
        model.report.leave_out_block(block, "it ties no node")
    _add_rigid(found, f"rigid_body_{ids.nodes[reference]}", reference, nodes, block.line, freedoms)
    for node in pinned:
        arm = model.positions[node] - model.positions[reference]
        for i in range(3):
            found.rows.add(
                rigid_terms(node, reference, arm, np.eye(3)[i]), block.line, dependent=6 * node + i
            )


# --- couplings


def _coupling(
    model: AbaqusModel,
    coupling: ScopedBlock,
    kind: ScopedBlock,
    freedoms: Freedoms,
    ids: PublicIds,
    found: DeckConstraints,
    solid_only: BoolArray,
    orientations: Mapping[tuple[int, str], Orientation],
) -> None:
    block = coupling.block
    reference = _reference(model, coupling)
    surface = model.surface(coupling.scope, block.options.get("SURFACE", ""))
    if reference is None:
        return
    if surface is None or not len(surface.nodes):
        model.report.leave_out_block(block, f"its surface '{block.options.get('SURFACE', '')}' is not read")
        return
    name = block.options.get("CONSTRAINTNAME") or f"coupling_{ids.nodes[reference]}"
    components = _range_of_components(model, kind)
    nodes, weights = surface.nodes, _tributary(model, surface)
    if "INFLUENCERADIUS" in block.options:
        radius = numbers(model.file, block.line, [block.options["INFLUENCERADIUS"]])[0]
        near = np.linalg.norm(model.positions[nodes] - model.positions[reference], axis=1) <= radius
        nodes, weights = nodes[near], weights[near]
    near = nodes != reference
    nodes, weights = nodes[near], weights[near]
    if not len(nodes):
        meaning = (
            "it ties no node: the only node of its surface within the influence radius is the reference node"
        )
        model.report.leave_out_block(block, meaning)
        return
    distributing = kind.block.key == "DISTRIBUTING"
    # Of a distributing coupling only rotations are released, whatever translations the file names.
    chosen = {*components, 1, 2, 3} if distributing else {*components}
    if distributing:
        if "ORIENTATION" in block.options and chosen not in _WHOLE:
            model.report.leave_out_block(block, "its freedoms are those of the global axes")
        if kind.block.options.get("WEIGHTINGMETHOD", "UNIFORM").upper() != "UNIFORM":
            model.report.note(
                f"coupling '{name}' uses the weights of the surface only, without those by distance"
            )
        follow = tuple(component in chosen for component in _ALL)
        found.means.append(
            WeightedMean(name, reference, nodes, weights, int(freedoms.lines[block.line]), follow)
        )
        return
    axes = _axes(model, coupling, orientations, nodes, [components])
    _kinematic(model, name, reference, nodes, components, block.line, freedoms, found, solid_only, axes)


def _axes(
    model: AbaqusModel,
    placed: ScopedBlock,
    orientations: Mapping[tuple[int, str], Orientation],
    nodes: IntArray,
    components: Collection[Collection[int]],
) -> FloatArray:
    """Axes (n, 3, 3) at nodes as columns: those of ORIENTATION, else global ones.

    An ORIENTATION that is not read is left out, if the coupled components depend on it.
    """
    name = placed.block.options.get("ORIENTATION", "").upper()
    found = orientations.get((placed.scope, name)) or orientations.get((0, name))
    if found is not None and not found.distributed:
        return found.axes(model.positions[nodes], np.full(len(nodes), -1))
    if name and any(set(each) not in _WHOLE for each in components):
        model.report.leave_out_block(placed.block, "its freedoms are those of the global axes")
    return np.tile(np.eye(3), (len(nodes), 1, 1))


def _range_of_components(model: AbaqusModel, placed: ScopedBlock) -> tuple[int, ...]:
    """Freedoms 1 to 6 in the ranges `first, last` of the data lines; all six without data lines."""
    found: set[int] = set()
    for line, text in placed.block.data:
        words = [word for word in fields(text) if word]
        if not words or not all(map(is_plain_digits, words[:2])):
            raise model.file.error(line, f"*{placed.block.name} takes first and last freedom, 1 to 6")
        found |= set(range(int(words[0]), min(int(words[:2][-1]), 6) + 1))
    return tuple(sorted(found)) if found else _ALL


def _kinematic(
    model: AbaqusModel,
    name: str,
    reference: int,
    nodes: IntArray,
    components: tuple[int, ...],
    line: int,
    freedoms: Freedoms,
    found: DeckConstraints,
    solid_only: BoolArray,
    directions: FloatArray,
) -> None:
    """Add a rigid tie if all freedoms of the nodes follow; else a constraint row for each component."""
    if set(components) == set(_ALL) or (set(components) >= {1, 2, 3} and solid_only[nodes].all()):
        _add_rigid(found, name, reference, nodes, line, freedoms)
        return
    for node, axes in zip(nodes.tolist(), directions, strict=True):
        arm = model.positions[node] - model.positions[reference]
        for component in components:
            column = axes[:, (component - 1) % 3]
            if component <= 3:
                terms = rigid_terms(node, reference, arm, column)
            elif solid_only[node]:
                continue
            else:
                terms = [(6 * node + 3 + i, float(column[i])) for i in range(3)]
                terms += [(6 * reference + 3 + i, -float(column[i])) for i in range(3)]
            found.rows.add(terms, line)


def _kinematic_coupling(
    model: AbaqusModel,
    placed: ScopedBlock,
    freedoms: Freedoms,
    ids: PublicIds,
    found: DeckConstraints,
    solid_only: BoolArray,
    orientations: Mapping[tuple[int, str], Orientation],
) -> None:
    reference = _reference(model, placed)
    if reference is None:
        return
    by_components: dict[tuple[int, ...], list[IntArray]] = {}
    for line, text in placed.block.data:
        word, *rest = fields(text)
        nodes = model.nodes_of(placed.scope, word, line, "*KINEMATIC COUPLING")
        limits = [int(value) for value in numbers(model.file, line, rest[:2]) if value]
        chosen = tuple(range(limits[0], min(limits[-1], 6) + 1)) if limits else _ALL
        by_components.setdefault(chosen, []).append(nodes)
    name = f"coupling_{ids.nodes[reference]}"
    # If all lines name the same nodes, their freedoms form one coupling.
    if len(by_components) > 1:
        groups = [np.unique(np.concatenate(nodes)) for nodes in by_components.values()]
        if all(np.array_equal(group, groups[0]) for group in groups):
            by_components = {tuple(sorted({c for each in by_components for c in each})): [groups[0]]}
    coupled = {components: np.unique(np.concatenate(nodes)) for components, nodes in by_components.items()}
    every = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *coupled.values()]))
    axes = _axes(model, placed, orientations, every, coupled)
    for components, nodes in coupled.items():
        own, line = axes[np.searchsorted(every, nodes)], placed.block.line
        _kinematic(model, name, reference, nodes, components, line, freedoms, found, solid_only, own)


def _distributing_coupling(
    model: AbaqusModel, placed: ScopedBlock, ids: PublicIds, found: DeckConstraints
) -> None:
    """Add the weighted mean of a *DISTRIBUTING COUPLING.

    The reference node is that of the DCOUP3D element in ELSET; a data line has a node or set, and a weight.
    """
    block = placed.block
    members = model.elements_of(
        placed.scope, block.options.get("ELSET", ""), block.line, "*DISTRIBUTING COUPLING"
    )
    references = model.nodes_of_elements(members)
    if len(references) != 1:
        model.report.leave_out_block(block, "its element is not one DCOUP3D")
        return
    nodes, weights = [], []
    for line, text in block.data:
        word, *rest = fields(text)
        these = model.nodes_of(placed.scope, word, line, "*DISTRIBUTING COUPLING")
        nodes.append(these)
        weights.append(np.full(len(these), (numbers(model.file, line, rest[:1]) or [1.0])[0] or 1.0))
    reference = int(references[0])
    if not sum(map(len, nodes)):
        model.report.leave_out_block(block, "it ties no node")
    else:
        found.means.append(
            WeightedMean(
                f"coupling_{ids.nodes[reference]}",
                reference,
                np.concatenate(nodes),
                np.concatenate(weights),
                model.file.lines[block.line][1],
            )
        )


def _tributary(model: AbaqusModel, surface: DeckSurface) -> FloatArray:
    """Tributary area of each node of a surface; 1 for each node if the surface has only edges or nodes."""
    weights = np.zeros(len(model.positions))
    for faces in surface.faces:
        n = faces.shape[1]
        if n < 3:
            np.add.at(weights, faces.ravel(), 1.0 if n == 1 else 0.0)
            continue
        corners = model.positions[faces[:, : 3 if n in (3, 6) else 4]]
        first, last = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
        if corners.shape[1] == 3:
            first, last = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = np.linalg.norm(np.cross(first, last), axis=1) / 2
        np.add.at(weights, faces, np.broadcast_to(area[:, None] / n, faces.shape))
    found = weights[surface.nodes]
    return found if found.sum() > 0 else np.ones(len(surface.nodes))

"""Multi-point constraints of Abaqus and CalculiX: equations, MPCs, rigid bodies and couplings."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel, DeckSurface
from supple.importers.abaqus.element_types import Family
from supple.importers.abaqus.freedoms import Freedoms
from supple.importers.abaqus.orientation import Orientations, nodal_axes
from supple.importers.deck import RigidTie, WeightedMean
from supple.importers.freedom_sums import FreedomSums, Terms, motion_along, relative_motion
from supple.importers.keyword_file import fields, numbers
from supple.importers.plain_number import is_plain_digits

_ALL = (1, 2, 3, 4, 5, 6)
_WHOLE = ({1, 2, 3}, {4, 5, 6}, {*_ALL})  # the same in all axes
_MPC_NODES = {"TIE": 2, "PIN": 2, "BEAM": 2, "LINK": 2, "LINEAR": 3, "SLIDER": 3, "QUADRATIC": 4}


def read_constraints(
    model: AbaqusModel, freedoms: Freedoms, node_ids: IntArray, orientations: Orientations
) -> DeckConstraints:
    """All constraints of a file except *TIE.

    Freedoms of kinematic couplings are in the axes of ORIENTATION at each node, else in global axes; those of
    *TRANSFORM have no effect on them, in Abaqus as in CalculiX. A node without rotations follows a rigid body
    or coupling in its translations only.

    Raises
    ------
    ImportFormatError   incomplete equations; words instead of numbers
    """
    found = DeckConstraints(model, freedoms, node_ids, orientations)
    for placed in model.named("RIGIDBODY"):
        found.add_rigid_body(placed)
    for placed in model.named("EQUATION"):
        found.add_equations(placed)
    for placed in model.named("MPC"):
        found.add_mpcs(placed)
    coupling: ScopedBlock | None = None
    for placed in model.blocks:
        key = placed.block.key
        if placed.step or key not in ("COUPLING", "KINEMATIC", "DISTRIBUTING"):
            continue
        model.report.read[placed.block.name] += 1
        if key == "COUPLING":
            coupling = placed
        elif coupling is not None:
            found.add_coupling(coupling, placed)
    for placed in model.named("KINEMATICCOUPLING"):
        found.add_kinematic_coupling(placed)
    for placed in model.named("DISTRIBUTINGCOUPLING"):
        found.add_distributing_coupling(placed)
    return found


@dataclass(eq=False)
class DeckConstraints:
    """Constraint rows, rigid ties and weighted means, collected while reading."""

    model: AbaqusModel
    freedoms: Freedoms
    node_ids: IntArray
    orientations: Orientations
    rows: FreedomSums = field(default_factory=FreedomSums)
    rigid: list[RigidTie] = field(default_factory=list)
    means: list[WeightedMean] = field(default_factory=list)

    @cached_property
    def solid_only(self) -> BoolArray:
        """Mask (N,) of nodes without rotations: elements use them, but no shell, beam or rotary inertia."""
        turns = self.model.nodes_of_families(Family.SHELL, Family.BEAM, Family.ROTARY_INERTIA)
        return self.model.nodes_of_families(*Family) & ~turns

    # --- equations

    def add_equations(self, placed: ScopedBlock) -> None:
        """Add the equations of an *EQUATION."""
        file, data = self.model.file, placed.block.data
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
                raise file.error(
                    line, f"an equation of {wanted} terms has {len(found)}; is the file cut short?"
                )
            self._add_equation(placed.scope, line, found)

    def _add_equation(self, scope: int, line: int, terms: list[tuple[str, str, str]]) -> None:
        """Add one equation, or one equation for each node of the sets in its terms."""
        model = self.model
        groups = _groups([model.paired_nodes_of(scope, word, line, "*EQUATION") for word, _, _ in terms])
        if groups is None:
            model.report.leave_out("*EQUATION", line, "it names unknown nodes, or sets of different sizes")
            return
        factors = [numbers(model.file, line, [word])[0] for _, _, word in terms]
        components = [int(word) if is_plain_digits(word) else 0 for _, word, _ in terms]
        if not all(1 <= component <= 6 for component in components):
            model.report.leave_out("*EQUATION", line, "it names freedoms other than 1 to 6")
            return
        for nodes in groups:
            parts = [self.freedoms.of(*each) for each in zip(nodes, components, factors, strict=True)]
            dependent = parts[0][0][0] if len(parts[0]) == 1 else -1
            self.rows.add(chain(*parts), model.file.numbers[line], dependent=dependent)

    # --- MPCs

    def add_mpcs(self, placed: ScopedBlock) -> None:
        """Add the constraints of an *MPC."""
        model, data = self.model, placed.block.data
        i = 0
        while i < len(data):
            line, text = data[i]
            words = fields(text)
            kind = words[0].upper()
            i += 1
            # CalculiX continues after a comma with a line of more nodes, with or without a leading 0.
            while (
                i < len(data)
                and data[i - 1][1].rstrip().endswith(",")
                and is_plain_digits(fields(data[i][1])[0])
            ):
                words += fields(data[i][1])
                i += 1
            nodes = [model.paired_nodes_of(placed.scope, word, line, "*MPC") for word in words[1:] if word]
            groups = _groups(nodes) if len(nodes) == _MPC_NODES.get(kind) else None
            if groups is None or len(groups) != len(nodes[0]):
                model.report.leave_out(f"*MPC, {kind}", line, "its nodes are not tied")
                continue
            for first, *others in groups:
                if kind == "BEAM":
                    (second,) = others
                    self._add_rigid(f"mpc_{self.node_ids[second]}", second, np.array([first]), line)
                else:
                    for terms, dependent in mpc_rows(kind, first, others, model.positions):
                        self.rows.add(terms, model.file.numbers[line], dependent=dependent)

    # --- rigid bodies

    def _add_rigid(self, name: str, reference: int, nodes: IntArray, line: int) -> None:
        """Add nodes to the rigid tie with this name and reference node, or make such a tie."""
        nodes = np.unique(nodes)
        nodes = nodes[nodes != reference]
        for i, other in enumerate(self.rigid):
            if other.name == name and other.reference == reference:
                joined = np.union1d(other.nodes, nodes)
                self.rigid[i] = RigidTie(name, reference, joined, other.line)
                return
        if len(nodes):
            self.rigid.append(RigidTie(name, reference, nodes, int(self.model.file.numbers[line])))

    def _reference(self, placed: ScopedBlock) -> int | None:
        """The number of the node REF NODE; None if the option does not name exactly one node of the file."""
        block, report = placed.block, self.model.report
        word = block.options.get("REFNODE", "")
        nodes = self.model.nodes_of(placed.scope, word, block.line, f"*{block.name}, REF NODE")
        if len(nodes) != 1:
            report.leave_out_block(block, f"its reference node '{word}' is not exactly one node of the file")
            return None
        return int(nodes[0])

    def add_rigid_body(self, placed: ScopedBlock) -> None:
        """Add a *RIGID BODY."""
        model, block, scope = self.model, placed.block, placed.scope
        reference = self._reference(placed)
        if reference is None:
            return
        if "".join(block.options.get("POSITION", "").upper().split()) == "CENTEROFMASS":
            model.report.leave_out_block(block, "its reference node is not moved to the centre of mass")

        def nodes_of(option: str) -> IntArray:
            return model.nodes_of(scope, block.options[option], block.line, f"*{block.name}")

        tied = [nodes_of(option) for option in ("NSET", "TIENSET") if option in block.options]
        if "ELSET" in block.options:
            members = model.elements_of(scope, block.options["ELSET"], block.line, f"*{block.name}")
            tied.append(model.nodes_of_elements(members))
        pinned = nodes_of("PINNSET").tolist() if "PINNSET" in block.options else []
        if "ROTNODE" in block.options:
            self.freedoms.rotation_nodes |= dict.fromkeys(nodes_of("ROTNODE").tolist(), reference)
        if not tied and not pinned:
            model.report.leave_out_block(block, "its analytical surface is not tied to anything")
            return
        nodes = np.concatenate([np.empty(0, dtype=np.int64), *tied])
        if not len(nodes) and not pinned:
            model.report.leave_out_block(block, "it ties no node")
        self._add_rigid(f"rigid_body_{self.node_ids[reference]}", reference, nodes, block.line)
        for node in pinned:
            for i in range(3):
                self._add_follower(node, reference, np.eye(3)[i], block.line, dependent=6 * node + i)

    def _add_follower(
        self,
        node: int,
        reference: int,
        direction: FloatArray,
        line: int,
        *,
        rotation: bool = False,
        dependent: int = -1,
    ) -> None:
        """Add the constraint that a node follows the rigid motion of the reference node along a direction."""
        arm = self.model.positions[node] - self.model.positions[reference]
        terms = relative_motion(node, reference, direction, arm=arm, rotation=rotation)
        self.rows.add(terms, self.model.file.numbers[line], dependent=dependent)

    # --- couplings

    def add_coupling(self, coupling: ScopedBlock, kind: ScopedBlock) -> None:
        """Add a *COUPLING with its *KINEMATIC or *DISTRIBUTING."""
        model, block = self.model, coupling.block
        reference = self._reference(coupling)
        surface = model.surface(coupling.scope, block.options.get("SURFACE", ""))
        if reference is None:
            return
        if surface is None or not len(surface.nodes):
            meaning = f"its surface '{block.options.get('SURFACE', '')}' is not read"
            model.report.leave_out_block(block, meaning)
            return
        name = block.options.get("CONSTRAINTNAME") or f"coupling_{self.node_ids[reference]}"
        components = self._range_of_components(kind)
        near = surface.nodes != reference
        if "INFLUENCERADIUS" in block.options:
            radius = numbers(model.file, block.line, [block.options["INFLUENCERADIUS"]])[0]
            arms = model.positions[surface.nodes] - model.positions[reference]
            near &= np.linalg.norm(arms, axis=1) <= radius
        nodes, weights = surface.nodes[near], _tributary(model, surface)[near]
        if not len(nodes):
            meaning = (
                "it ties no node: the only node of its surface within the influence radius is the reference "
                "node"
            )
            model.report.leave_out_block(block, meaning)
            return
        if kind.block.key != "DISTRIBUTING":
            axes = self._axes(coupling, nodes, [components])
            self._add_kinematic(name, reference, nodes, components, block.line, axes)
            return
        # Of a distributing coupling only rotations are released, whatever translations the file names.
        chosen = {*components, 1, 2, 3}
        if "ORIENTATION" in block.options and chosen not in _WHOLE:
            model.report.leave_out_block(block, "its freedoms are those of the global axes")
        if kind.block.options.get("WEIGHTINGMETHOD", "UNIFORM").upper() != "UNIFORM":
            model.report.note(
                f"coupling '{name}' uses the weights of the surface only, without those by distance"
            )
        line, follow = int(model.file.numbers[block.line]), tuple(i in chosen for i in _ALL)
        self.means.append(WeightedMean(name, reference, nodes, weights, line, follow))

    def _axes(
        self, placed: ScopedBlock, nodes: IntArray, components: Collection[Collection[int]]
    ) -> FloatArray:
        """Axes (n, 3, 3) at nodes as columns: those of ORIENTATION, else global ones.

        An ORIENTATION that is not read is left out, if the coupled components depend on it.
        """
        found = nodal_axes(self.model, placed, self.orientations, nodes)
        if found is not None:
            return found
        if placed.block.options.get("ORIENTATION") and any(set(each) not in _WHOLE for each in components):
            meaning = "its freedoms are those of the global axes"
            self.model.report.leave_out_block(placed.block, meaning)
        return np.tile(np.eye(3), (len(nodes), 1, 1))

    def _range_of_components(self, placed: ScopedBlock) -> tuple[int, ...]:
        """Freedoms 1 to 6 in the ranges `first, last` of the data lines; all six without data lines."""
        found: set[int] = set()
        for line, text in placed.block.data:
            words = [word for word in fields(text) if word]
            if not words or not all(map(is_plain_digits, words[:2])):
                message = f"*{placed.block.name} takes first and last freedom, 1 to 6"
                raise self.model.file.error(line, message)
            found |= set(range(int(words[0]), min(int(words[:2][-1]), 6) + 1))
        return tuple(sorted(found)) if found else _ALL

    def _add_kinematic(
        self,
        name: str,
        reference: int,
        nodes: IntArray,
        components: tuple[int, ...],
        line: int,
        directions: FloatArray,
    ) -> None:
        """Add a rigid tie if all freedoms of the nodes follow; else a constraint row for each component."""
        solid_only = self.solid_only
        if set(components) == set(_ALL) or (set(components) >= {1, 2, 3} and solid_only[nodes].all()):
            self._add_rigid(name, reference, nodes, line)
            return
        for node, axes in zip(nodes.tolist(), directions, strict=True):
            for component in components:
                turns = component > 3
                if not (turns and solid_only[node]):
                    self._add_follower(node, reference, axes[:, (component - 1) % 3], line, rotation=turns)

    def add_kinematic_coupling(self, placed: ScopedBlock) -> None:
        """Add a *KINEMATIC COUPLING."""
        model = self.model
        reference = self._reference(placed)
        if reference is None:
            return
        by_components: dict[tuple[int, ...], list[IntArray]] = {}
        for line, text in placed.block.data:
            word, *rest = fields(text)
            nodes = model.nodes_of(placed.scope, word, line, "*KINEMATIC COUPLING")
            limits = [int(value) for value in numbers(model.file, line, rest[:2]) if value]
            chosen = tuple(range(limits[0], min(limits[-1], 6) + 1)) if limits else _ALL
            by_components.setdefault(chosen, []).append(nodes)
        coupled = {each: np.unique(np.concatenate(nodes)) for each, nodes in by_components.items()}
        # If all lines name the same nodes, their freedoms form one coupling.
        groups = list(coupled.values())
        if len(groups) > 1 and all(np.array_equal(group, groups[0]) for group in groups):
            coupled = {tuple(sorted({c for each in coupled for c in each})): groups[0]}
        every = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *coupled.values()]))
        axes = self._axes(placed, every, coupled)
        name = f"coupling_{self.node_ids[reference]}"
        for components, nodes in coupled.items():
            own = axes[np.searchsorted(every, nodes)]
            self._add_kinematic(name, reference, nodes, components, placed.block.line, own)

    def add_distributing_coupling(self, placed: ScopedBlock) -> None:
        """Add the weighted mean of a *DISTRIBUTING COUPLING.

        The reference node is that of the DCOUP3D element in ELSET; a data line has a node or set, and a
        weight.
        """
        model, block, what = self.model, placed.block, "*DISTRIBUTING COUPLING"
        members = model.elements_of(placed.scope, block.options.get("ELSET", ""), block.line, what)
        references = model.nodes_of_elements(members)
        if len(references) != 1:
            model.report.leave_out_block(block, "its element is not one DCOUP3D")
            return
        nodes, weights = [], []
        for line, text in block.data:
            word, *rest = fields(text)
            these = model.nodes_of(placed.scope, word, line, what)
            nodes.append(these)
            weights.append(np.full(len(these), (numbers(model.file, line, rest[:1]) or [1.0])[0] or 1.0))
        if not sum(map(len, nodes)):
            model.report.leave_out_block(block, "it ties no node")
            return
        reference, line = int(references[0]), int(model.file.numbers[block.line])
        name = f"coupling_{self.node_ids[reference]}"
        mean = WeightedMean(name, reference, np.concatenate(nodes), np.concatenate(weights), line)
        self.means.append(mean)


def _groups(nodes: list[IntArray]) -> list[list[int]] | None:
    """Groups of one node from each set; a set of one node is in every group. None if sizes differ."""
    count = max(map(len, nodes))
    if not count or any(len(each) not in (1, count) for each in nodes):
        return None
    return np.stack([np.broadcast_to(each, count) for each in nodes], axis=1).tolist()


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


# --- linearised *MPC except BEAM, which is a rigid tie


def mpc_rows(
    kind: str, first: int, others: Sequence[int], positions: FloatArray
) -> Iterator[tuple[Terms, int]]:
    """Constraint rows, each with the freedom that it eliminates, or -1.

    p is the node `first`; a, b, c are the nodes `others`.

    TIE, PIN           u_p = u_a, with or without rotations
    LINK               constant distance between p and a
    LINEAR, QUADRATIC  displacement and rotation of p are interpolated on the edge a b, or a b c
    SLIDER             p stays on the line through a and b
    """
    p, place = first, positions[first]
    if kind == "LINK":
        (a,) = others
        span = place - positions[a]
        if np.linalg.norm(span) > 0:
            yield relative_motion(p, a, span / np.linalg.norm(span)), -1
        return
    if kind == "SLIDER":
        a, b = others
        along_line = positions[b] - positions[a]
        if np.linalg.norm(along_line) > 0:
            share = float((place - positions[a]) @ along_line / (along_line @ along_line))
            for across in np.linalg.svd(along_line[None])[2][1:]:
                weights = ((p, 1.0), (a, share - 1.0), (b, -share))
                yield [term for n, w in weights for term in motion_along(n, across, w)], -1
        return
    shares = [1.0] if len(others) == 1 else _shares(place, positions[list(others)])
    for component in range(3 if kind == "PIN" else 6):
        terms = [(6 * n + component, -share) for n, share in zip(others, shares, strict=True)]
        yield [(6 * p + component, 1.0), *terms], 6 * p + component


def _shares(place: FloatArray, nodes: FloatArray) -> list[float]:
    """Shape functions of the nodes of an edge at a position on it, linear or quadratic.

    On a quadratic edge x(s) = sum_i N_i(s) x_i, the position determines s; the middle node need not be
    halfway.
    """
    if len(nodes) == 2:
        chord = nodes[1] - nodes[0]
        s = float((place - nodes[0]) @ chord / (chord @ chord))
        return [1 - s, s]
    distance = np.linalg.norm(nodes[:, None] - nodes, axis=2)
    middle = int(np.argmin(distance.sum(axis=1)))
    first, last = (i for i in range(3) if i != middle)
    chord = nodes[last] - nodes[first]
    t, at = ((x - nodes[first]) @ chord / (chord @ chord) for x in (nodes[middle], place))
    # The middle node is at t along the chord (0 to 1), the point s at s^2 (2 - 4 t) + s (4 t - 1).
    b = 4 * t - 1
    s = float(2 * at / (b + np.sqrt(max(b**2 + 4 * (2 - 4 * t) * at, 0.0))))
    shares = [0.0, 0.0, 0.0]
    shares[first], shares[middle], shares[last] = (1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)
    return shares

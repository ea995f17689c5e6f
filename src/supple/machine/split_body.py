"""Split of a flexible body into several parts, each with its own floating frame."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.algebra import lowest_modes
from supple.body import AveragingInterface, FlexibleBody, RigidInterface, flexible_body
from supple.errors import ModelError, SuppleWarning
from supple.fem import FiniteElementModel, parts_of_model
from supple.machine.ends import At
from supple.machine.joints.fixed import Fixed
from supple.mesh import Cuts, DividedMesh, Division, cuts_at_sections, divided

__all__ = ["SplitBody", "split_body"]

# Relative change of a frequency, caused by the ties, from which a warning is given.
NOTABLE = 0.02

Interface = RigidInterface | AveragingInterface
Tie = Callable[..., Interface]


@dataclass(frozen=True, eq=False)
class SplitBody:
    """Parts of a body, and the joints between them.

    name  : str            name of the whole body
    mesh  : DividedMesh    nodes and cells of each part
    parts : FlexibleBody   with the names NAME-1, NAME-2, ..., all in the axes of the whole mesh
    base  : At             first interface of the whole body, on the part that has it; None without interfaces
    """

    name: str
    mesh: DividedMesh
    parts: tuple[FlexibleBody, ...]
    base: At | None = None

    @property
    def joints(self) -> tuple[Fixed, ...]:
        """Fixed joints between the parts, one at each cut."""
        return tuple(
            Fixed(
                first=At(part_name(self.name, cut.first), cut.name),
                second=At(part_name(self.name, cut.second), cut.name),
                name=f"{self.name} {tie}",
            )
            for tie, cut in self.mesh.ties.items()
        )

    @property
    def bases(self) -> Mapping[str, At]:
        """Interface relative to which deflections are measured, by name of the part: `base` for all parts."""
        return {} if self.base is None else {part.name: self.base for part in self.parts}

    def frequencies(self, count: int) -> NDArray[np.float64]:
        """The `count` lowest elastic frequencies of the tied parts, free and undeformed, rad/s.

        They differ from those of the whole body: rigid ties stiffen sections that would deform, averaging
        ties soften them.
        """
        first = np.cumsum([0, *(part.n for part in self.parts)])
        rows = []
        for cut in self.mesh.cuts:
            sides = [sparse.csr_array((6, part.n)) for part in self.parts]
            sides[cut.first] = self.parts[cut.first].interface(cut.name).motion
            sides[cut.second] = -self.parts[cut.second].interface(cut.name).motion
            rows.append(sparse.hstack(sides))
        mass = sparse.block_diag([part.mass for part in self.parts], format="csc")
        rigid = np.zeros((first[-1], 6))
        for part, begin in zip(self.parts, first, strict=False):
            rigid[begin : begin + part.n] = part.rigid_modes
        found = lowest_modes(
            sparse.block_diag([part.stiffness for part in self.parts], format="csc"),
            mass,
            count,
            constraint=np.vstack([sparse.vstack(rows).toarray(), (mass @ rigid).T]),
        )
        return np.sqrt(found.values)


def frequency_changes(whole: FlexibleBody, split: SplitBody) -> NDArray[np.float64]:
    """Relative changes (3,) of the lowest elastic frequencies of a free body due to the ties of its parts.

    Warns SuppleWarning if a frequency changes by 2 % or more.
    """
    before = np.sqrt(whole.lowest_modes(3, (whole.mass @ whole.rigid_modes).T).values)
    changes = split.frequencies(3) / before - 1
    if np.abs(changes).max() >= NOTABLE:
        listed = ", ".join(f"{100 * change:+.2g}" for change in changes)
        warnings.warn(
            f"body '{whole.name}': the ties of its {len(split.parts)} parts change the lowest free "
            f"frequencies by {listed} %. Rigid ties stiffen sections that would deform, averaging ties "
            "soften them: cut where sections do not deform, or try the other tie (rigid, averaging)",
            SuppleWarning,
            stacklevel=3,
        )
    return changes


def split_body(
    name: str,
    model: FiniteElementModel,
    division: Division,
    interfaces: Sequence[Interface] = (),
    *,
    tie: Tie = RigidInterface,
    cuts: Cuts = cuts_at_sections,
) -> SplitBody:
    """Split a body into parts joined by ties, for rotations beyond the limit of one floating frame.

    With k equal parts, a part rotates relative to its own frame by about 1 / k of the rotation of the whole
    body relative to one frame.

    Parameters
    ----------
    name       : name of the whole body
    model      : finite-element model of the whole body
    division   : AlongAxis | ByCellSets     assigns the cells to parts
    interfaces : interfaces of the whole body; each is assigned to the part that contains all of its nodes
    tie        : RigidInterface (sections keep their shape) | AveragingInterface (sections may warp)
    cuts       : cuts_at_sections, one tie for all shared nodes of a cut | cuts_at_nodes, a tie of six
        constraints for each shared node; these ties are exact for nodes with rotations

    Raises
    ------
    MeshError    a part without cells, or a part that is not connected
    ModelError   an interface, spring, mass or tie whose nodes are in several parts; errors of `flexible_body`
                 for a part
    Warns
    -----
    SuppleWarning   the ties change one of the three lowest frequencies of the free body by 2 % or more
    """
    mesh = divided(model.mesh, division, cuts)
    own: list[list[Interface]] = [[] for _ in mesh.parts]
    base = None
    for interface in interfaces:
        given = interface.nodes
        nodes = model.mesh.nodes_of(given) if isinstance(given, str) else np.atleast_1d(np.asarray(given))
        part = mesh.holder(nodes)
        if part is None:
            raise ModelError(
                f"body '{name}', interface '{interface.name}': its nodes are in several of the "
                f"{len(mesh.parts)} parts; move the cut away from these nodes"
            )
        own[part].append(replace(interface, nodes=mesh.parts[part].numbers(nodes)))
        base = base or At(part_name(name, part), interface.name)
    for number, part in enumerate(mesh.parts):
        for cut, nodes in mesh.cut_nodes(number).items():
            centre = model.mesh.nodes[nodes].mean(axis=0)
            own[number].append(tie(cut, part.numbers(nodes), position=centre))
    bodies = tuple(
        flexible_body(part_name(name, i), part, own[i]) for i, part in enumerate(parts_of_model(model, mesh))
    )
    split = SplitBody(name, mesh, bodies, base)
    frequency_changes(flexible_body(name, model, interfaces), split)
    return split


def part_name(name: str, part: int) -> str:
    """Name of a part of a body by the number of the part, from 0: `blade-1` for part 0 of `blade`."""
    return f"{name}-{part + 1}"

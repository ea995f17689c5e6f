"""Split bodies of a case: tables of their parts, and joints between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from supple.arrays import IntArray
from supple.body import BodySource, elements_source
from supple.cases.body_kinds import kind_of, kinds_that
from supple.cases.shared_rules import BODY_AXIS
from supple.errors import ModelError
from supple.fem import FiniteElementModel, parts_of_model
from supple.importers import Connection
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, Vector, table
from supple.machine.split_body import part_name
from supple.mesh import (
    AlongAxis,
    ByCellSets,
    DividedMesh,
    Division,
    MeshPart,
    cuts_at_nodes,
    cuts_at_sections,
    divided,
)
from supple.mesh.outer_faces import outer_triangles


class Split(CheckedTable):
    """Division of the body into parts with a frame each, tied at their cuts: for large rotations."""

    model_config = BODY_AXIS

    parts: int | None = Field(None, ge=2, description="number of parts, of equal length along body_axis")
    body_axis: Vector | None = Field(
        None, description="direction in body axes; default: the longest one of the mesh"
    )
    cell_sets: Annotated[tuple[str, ...], Field(strict=False)] | None = Field(
        None, description="instead of parts: the cell sets that are the parts"
    )
    tie: Literal["rigid", "averaging", "nodes"] = Field(
        "rigid",
        description="sections between parts are rigid, or may warp, or each shared node is tied individually",
    )

    def division(self) -> Division:
        """How the cells are assigned to parts."""
        if self.cell_sets is not None:
            return ByCellSets(self.cell_sets)
        return AlongAxis(self.parts or 2, self.body_axis)


@dataclass(frozen=True, eq=False)
class SplitSource:
    """The sources of a split body.

    whole : source of the undivided body
    mesh  : meshes of its parts
    parts : source of each part, by its name; their meshes have node sets `cut-1 of NAME` and so on, or
        `node-ID of NAME`
    """

    name: str
    whole: BodySource
    mesh: DividedMesh
    parts: Mapping[str, BodySource]

    def places(self, nodes: IntArray) -> list[tuple[str, IntArray]]:
        """Name of each part with some of the nodes, and their numbers in the part.

        A node of a cut is assigned to one part only.

        nodes : node numbers in the undivided body
        """
        part = self.mesh.holder(nodes)
        if part is not None:
            return [(part_name(self.name, part), self.mesh.parts[part].numbers(nodes))]
        inside = np.array([np.isin(nodes, own.nodes) for own in self.mesh.parts])
        owner = inside.argmax(axis=0)
        return [
            (part_name(self.name, part), self.mesh.parts[part].numbers(nodes[owner == part]))
            for part in np.unique(owner).tolist()
        ]


@lru_cache(maxsize=16)
def pressed_triangles(split: SplitSource, part: str, node_set: str) -> IntArray:
    """Triangles (T, 3) of the outer faces of a part with all corners in a set of the undivided body.

    Corners at a cut count in every part that has them. The cut itself is no outer face. The result is cached
    because all cases of a sweep have the same faces.

    part : name of the part;  node_set : of the undivided body
    """
    whole, own = split.whole.mesh, split.mesh.parts[list(split.parts).index(part)]
    assert whole is not None
    nodes = whole.nodes_of(node_set)
    faces = outer_triangles(own.mesh, own.numbers(nodes[np.isin(nodes, own.nodes)]))
    outer = set(map(frozenset, outer_triangles(whole, nodes).tolist()))
    kept = [frozenset(face) in outer for face in own.nodes[faces].tolist()]
    return faces[np.array(kept, dtype=bool)]


def split_source(name: str, source: BodySource, split: Split) -> SplitSource:
    """The parts of a body.

    Raises
    ------
    MeshError    a part without cells, or not connected; an unknown cell set
    ModelError   a connection whose nodes lie in several parts
    """
    assert source.mesh is not None  # a rule of the case file
    cuts = cuts_at_nodes if split.tie == "nodes" else cuts_at_sections
    mesh = divided(source.mesh, split.division(), cuts)
    connections = [(mesh.holder(each.nodes), each) for each in source.connections()]
    for holder, each in connections:
        if holder is None:
            raise ModelError(
                f"body '{name}': the nodes of {each.name} are in several parts; move the cut away from it"
            )
    with_cuts = [_with_cuts(part, i, mesh, name) for i, part in enumerate(mesh.parts)]

    @cache
    def models() -> tuple[FiniteElementModel, ...]:
        assert source.model is not None
        return parts_of_model(source.model(), replace(mesh, parts=tuple(with_cuts)))

    parts = {}
    for i, part in enumerate(with_cuts):
        own = tuple(
            Connection(each.name, part.numbers(each.nodes), each.position, each.weights)
            for holder, each in connections
            if holder == i
        )
        made = elements_source(part.mesh, lambda i=i: models()[i], own)
        parts[part_name(name, i)] = replace(made, ties_itself=source.ties_itself)
    return SplitSource(name, source, mesh, parts)


def _with_cuts(part: MeshPart, number: int, mesh: DividedMesh, name: str) -> MeshPart:
    """A part with node sets at its cuts."""
    cuts = {f"{cut} of {name}": part.numbers(nodes) for cut, nodes in mesh.cut_nodes(number).items()}
    return replace(part, mesh=replace(part.mesh, node_sets={**part.mesh.node_sets, **cuts}))


def _is_divided_one_way(path: KeyPath, body: Raw) -> Mistakes:
    """The rules on the table of a split."""
    given = table(body, "split")
    if "split" not in body:
        return
    kind = kind_of(body)
    if kind is not None and not kind.has_elements:
        able = ", ".join(kinds_that("has_elements"))
        yield (*path, "split"), f"only a body with elements can be split ({able}); remove the key"
    ways = [key for key in ("parts", "cell_sets") if key in given]
    if len(ways) != 1:
        seen = " and ".join(ways) or "neither"
        yield (*path, "split"), f"a split needs parts = 2, or cell_sets = [...]; this one has {seen}"
    if "cell_sets" in given and "body_axis" in given:
        yield (*path, "split", "body_axis"), "parts from cell sets have no body_axis; remove the key"
    sets = given.get("cell_sets")
    if isinstance(sets, list) and len(sets) < 2:
        yield (*path, "split", "cell_sets"), f"a split needs at least two cell sets; got {sets}"
    if table(body, "damping").get("kind") == "modal":
        message = (
            'modal damping would damp the modes of the parts, not those of the body; give kind = "rayleigh"'
        )
        yield (*path, "damping"), message


RULES_OF_BODY = (_is_divided_one_way,)

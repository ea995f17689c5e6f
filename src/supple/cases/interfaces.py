"""The interfaces of a body, for joints, loads and springs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from supple.body import AveragingInterface, RigidInterface, connection_interface, connection_named
from supple.cases.body_kinds import Rigid, SectionTableFile, Superelement, kind_of, kinds_that
from supple.importers import Connection
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, NodeIndices, Raw, Vector, tables


class InterfaceTable(CheckedTable):
    """A named place on a body for joints, loads and springs."""

    name: str = Field(min_length=1, description="used as BODY.NAME by joints, loads and output")
    nodes: str | None = Field(None, description="a node set of the mesh")
    node_indices: NodeIndices | None = Field(
        None, description="ids of nodes in the mesh file, instead of a node set; counted from 0 without ids"
    )
    connection: str | None = Field(
        None, description="rbe2_ID or rbe3_ID of a Nastran mesh, instead of nodes, kind and position"
    )
    kind: Literal["rigid", "averaging"] = Field("rigid", description="rigid (RBE2) or averaging (RBE3)")
    position: Vector | None = Field(
        None, description="point in body axes, a length; default for elastic bodies: the set's centroid"
    )

    def build(
        self, connections: Sequence[Connection], numbers: Callable[[np.ndarray], np.ndarray]
    ) -> RigidInterface | AveragingInterface:
        """The interface of an elastic body.

        connections : RBE2 and RBE3 elements of the body's file
        numbers : function from ids in the body's file to node numbers
        """
        if self.connection is not None:
            return connection_interface(connection_named(self.connection, connections), self.name)
        kind = RigidInterface if self.kind == "rigid" else AveragingInterface
        nodes = self.nodes if self.nodes is not None else numbers(np.array(self.node_indices))
        return kind(self.name, nodes, position=self.position)


def _interfaces_suit_their_body(path: KeyPath, body: Raw) -> Mistakes:
    """The rule that the keys of an interface fit the kind of its body."""
    kind = kind_of(body)
    if "reduced" in body:  # the file contains the interfaces
        return
    if kind is SectionTableFile and "condense" in body:  # rules on stations apply instead
        return
    for place, interface in tables(body, "interface", path):
        sources = [key for key in ("nodes", "node_indices", "connection") if key in interface]
        if kind is not None and issubclass(kind, Rigid):
            if sources:
                message = f"a rigid body has no nodes; give position instead of {sources[0]}"
                yield (*place, sources[0]), message
            elif "position" not in interface:
                yield place, "an interface of a rigid body needs position = [x, y, z] in body axes"
        elif len(sources) != 1:
            yield (
                place,
                "an interface needs one of nodes (a node set's name), node_indices and connection (an "
                f"RBE2 or RBE3); this one has {' and '.join(sources) or 'none'}",
            )
        elif sources == ["connection"]:
            if kind is None or not kind.has_connections:
                able = " and ".join(kinds_that("has_connections"))
                yield (*place, "connection"), f"only {able} bodies have connections; give nodes"
            for key in (key for key in ("kind", "position") if key in interface):
                yield (*place, key), f"the mesh file defines the {key} of a connection; remove the key"
        elif kind is Superelement and "nodes" in interface:
            yield (*place, "nodes"), "a superelement has no node sets; give node_indices (from 0) instead"


RULES_OF_BODY = (_interfaces_suit_their_body,)

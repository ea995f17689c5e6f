"""Tie of nodes to another part."""

from __future__ import annotations

from dataclasses import dataclass, field

from supple.arguments import check_fields
from supple.machine.ends import At
from supple.machine.ties.collocated import Collocated
from supple.machine.ties.continuity import EveryNode, MeanMotion
from supple.machine.ties.mortar import Mortar

__all__ = ["Tie"]


@dataclass(frozen=True)
class Tie:
    """Nodes that move with another part, in explicit runs.

    nodes : At(part, node set)
    on : str    the part that the nodes are tied to. Nodes tied to a part of finite elements must be at nodes
                of this part. Nodes tied to a modal part may be anywhere on the faces of its cells. Nodes of a
                modal part can be tied only to another modal part
    within : float      largest distance of the nodes from the part, relative to the size of the set
    transfer : Collocated() or Mortar()     how nodes follow a modal part with another mesh
    continuity : MeanMotion() or EveryNode(..)      continuity of two modal parts; not used for nodes of
                finite elements, which are tied one by one
    """

    nodes: At
    on: str
    within: float = 1e-6
    transfer: Collocated | Mortar = field(default_factory=Collocated)
    continuity: MeanMotion | EveryNode = field(default_factory=MeanMotion)

    def __post_init__(self) -> None:
        check_fields(self)

"""Nodes that move with another part."""

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
    """Nodes that move with another part of an explicit march.

    nodes : At(part, node set)
    on : str    the part they are tied to: one of finite elements, whose nodes they must meet, or a modal
                one, on whose material they hang wherever they lie on its cells. Nodes of a modal part are
                tied on a modal one only
    within : float      of the size of the set: how far from the part nodes may lie
    transfer : Collocated() or Mortar()     how nodes follow a modal part where the meshes do not match
    continuity : MeanMotion() or EveryNode(..)      continuity of two modal parts; nodes of finite
                elements hang position for position
    """

    nodes: At
    on: str
    within: float = 1e-6
    transfer: Collocated | Mortar = field(default_factory=Collocated)
    continuity: MeanMotion | EveryNode = field(default_factory=MeanMotion)

    def __post_init__(self) -> None:
        check_fields(self)

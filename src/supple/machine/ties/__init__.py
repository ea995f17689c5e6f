"""What ties the nodes of a part to another: where they meet, and what is equal there."""

from supple.machine.ties.collocated import Collocated
from supple.machine.ties.continuity import EveryNode, MeanMotion
from supple.machine.ties.mortar import Mortar
from supple.machine.ties.tie import Tie

__all__ = ["Collocated", "EveryNode", "MeanMotion", "Mortar", "Tie"]

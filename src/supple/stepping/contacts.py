"""Which stops and contacts of an exported machine touch: what changes at an impact."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp

from supple.equations.build_model import force_group_of
from supple.equations.configuration import SystemMotion
from supple.equations.ends import markers
from supple.equations.machine_model import STATIC, ForceGroup
from supple.equations.marker import Marker, pose
from supple.machine import ForceElement, System

__all__ = ["Contacts", "contacts_of"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Contacts:
    """The force elements of a machine that act by a penalty, one group for each."""

    kinds: tuple[type[ForceElement], ...] = field(metadata=STATIC)
    groups: tuple[ForceGroup, ...]

    def at(self, motion: SystemMotion) -> Any:
        """(c,) whether each touches: its penalty stores energy."""
        no_law: Any = None
        flags = [
            kind.energy(*_ends(group, motion), no_law, tuple(jnp.asarray(own)[0] for own in group.parameters))
            > 0
            for kind, group in zip(self.kinds, self.groups, strict=True)
        ]
        return jnp.stack(flags) if flags else jnp.zeros(0, dtype=bool)


def _ends(group: ForceGroup, motion: SystemMotion) -> list[Any]:
    ends = (markers(each, motion.configuration, motion.velocity) for each in (group.first, group.second))
    return [pose(Marker(*(jnp.asarray(leaf)[0] for leaf in each))) for each in ends]


def contacts_of(system: System) -> Contacts:
    """The stops and contacts of a machine, in the order of its loads."""
    elements = [each for each in system.loads if isinstance(each, ForceElement) and hasattr(each, "penalty")]
    groups = tuple(force_group_of(system, each) for each in elements)
    return Contacts(tuple(type(each) for each in elements), groups)

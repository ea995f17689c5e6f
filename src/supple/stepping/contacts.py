"""Stops and contacts of an exported machine, and which of them are closed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp

from supple.equations.build_model import force_group_of
from supple.equations.configuration import SystemMotion
from supple.equations.machine_model import STATIC, ForceGroup
from supple.machine import ForceElement, System
from supple.stepping.one_of_group import one_of, pose_of

__all__ = ["Contacts", "contacts_of"]


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Contacts:
    """The force elements of a machine that act by a penalty, each as a group of one element."""

    kinds: tuple[type[ForceElement], ...] = field(metadata=STATIC)
    groups: tuple[ForceGroup, ...]

    def at(self, motion: SystemMotion) -> Any:
        """Whether each element (c,) is closed: its penalty stores energy."""
        no_law: Any = None
        flags = [
            kind.energy(
                pose_of(group.first, motion),
                pose_of(group.second, motion),
                no_law,
                one_of(group.parameters, 0),
            )
            > 0
            for kind, group in zip(self.kinds, self.groups, strict=True)
        ]
        return jnp.stack(flags) if flags else jnp.zeros(0, dtype=bool)


def contacts_of(system: System) -> Contacts:
    """The stops and contacts of a machine, in the order of its loads."""
    elements = [each for each in system.loads if isinstance(each, ForceElement) and hasattr(each, "penalty")]
    groups = tuple(force_group_of(system, each) for each in elements)
    return Contacts(tuple(type(each) for each in elements), groups)

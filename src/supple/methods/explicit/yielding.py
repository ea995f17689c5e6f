"""Check whether a modal part, which is elastic, exceeds its yield stress at an output time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from supple.arrays import FloatArray
from supple.fem import isotropic_materials, stress_recovery, von_mises
from supple.integrate import FloatingMotion, Solution, Validity
from supple.machine import System
from supple.methods.explicit.materials import J2Plasticity
from supple.methods.explicit.modal_subdomain import ModalSubdomain
from supple.methods.explicit.peak_watch import Peak, PeakWatch


@dataclass(frozen=True, eq=False)
class _Limit:
    """Yield stress of a modal part.

    yield_stress : Pa;   whose : name of the part that gives it
    of_modes : (k, N, l, 6) stress at the nodes in l layers per modal coordinate, Pa
    """

    part: ModalSubdomain
    yield_stress: float
    whose: str
    of_modes: FloatArray


@dataclass(frozen=True, eq=False)
class YieldWatch(PeakWatch):
    """Yield stresses of the modal parts of a system, and the action when one is exceeded."""

    limits: tuple[_Limit, ...]

    def values(self, leg: Solution) -> Iterator[tuple[str, FloatArray]]:
        """Von Mises stresses (t, nodes) of each part, the largest over the layers."""
        for own in self.limits:
            rows = leg.motion(own.part.name, FloatingMotion).coordinates
            stresses = (np.einsum("k,knlc->nlc", row, own.of_modes) for row in rows)
            yield own.part.name, np.array([von_mises(each).max(axis=1) for each in stresses])

    def excesses(self, found: Mapping[str, Peak]) -> list[str]:
        """A message for every limit exceeded."""
        return [
            _yields(own, *found[own.part.name])
            for own in self.limits
            if found[own.part.name][0] > own.yield_stress
        ]


def yield_watch(system: System, validity: Validity) -> YieldWatch:
    """Prepare the limits of the modal parts of a system.

    A part without a yield stress gets the lowest yield stress of the explicit parts of its material; a part
    of several isotropic materials gets none. Parts without a limit, modes or elements are not checked.
    """
    found = []
    for part in system.bodies_of(ModalSubdomain).values():
        (limit, whose), model = _yield_stress(system, part), part.body.model
        if part.n_modes and model is not None and np.isfinite(limit):
            recovery = stress_recovery(model).linearized()
            of_modes = np.array([recovery.at_nodes(column) for column in part.nodal_basis.T])
            found.append(_Limit(part, limit, whose, of_modes))
    return YieldWatch(validity, tuple(found))


def _yield_stress(system: System, part: ModalSubdomain) -> tuple[float, str]:
    if part.yield_stress is not None:
        return part.yield_stress, part.name
    own = isotropic_materials(part.body.model) if part.body.model else set()
    laws = [(placed.body.name, getattr(placed.body, "law", None)) for placed in system.bodies]
    yields = [
        (float(law.hardening.yield_stress(jnp.zeros(()))), name)
        for name, law in laws
        if isinstance(law, J2Plasticity) and own == {law.elastic}
    ]
    return min(yields, default=(np.inf, part.name))


def _yields(own: _Limit, stress: float, time: float, node: int) -> str:
    name, model = own.part.name, own.part.body.model
    assert model is not None  # the stress is that of its elements
    whose = (
        "its yield stress"
        if own.whose == name
        else f"the yield stress of '{own.whose}', of the same material,"
    )
    return (
        f"part '{name}' is modal, so elastic, and reaches a von Mises stress of {stress:.4g} at node "
        f"{model.mesh.node_ids[node]} (t = {time:.4g}), above {whose} {own.yield_stress:.4g}: it would yield "
        "there. Use explicit elements in that region, or give another yield_stress of the modal part"
    )

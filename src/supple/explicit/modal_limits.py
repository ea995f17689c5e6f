"""Is the motion of modal parts within what linear modes describe? Watched at output times, with the number.

Modes are elastic: metal stressed beyond its yield stress would flow. They are small motions: beyond about
0.1 rad against the frame foreshortening counts. And they are those at rest: a part that spins at a good part
of its lowest frequency is stiffer.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.errors import ValidityError, ValidityWarning
from supple.explicit.explicit_system import ExplicitSystem
from supple.explicit.materials import J2Plasticity
from supple.explicit.modal_stress import isotropic_materials, modal_von_mises, stress_of_modes
from supple.explicit.modal_subdomain import ModalSubdomain
from supple.explicit.motions import FourPointMotion
from supple.integrate import Solution, Validity

__all__ = ["ModalPeaks", "ModalWatch", "modal_watch"]

FloatArray = NDArray[np.float64]

ROTATION_LIMIT = 0.1
"""rad against the frame: foreshortening, theta^2 / 2, is then half a percent of the length."""


class ModalPeaks(NamedTuple):
    """The largest of each quantity of a part, with its time; of stress also the number of the node."""

    stress: tuple[float, float, int] = (0.0, 0.0, 0)
    rotation: tuple[float, float] = (0.0, 0.0)
    spin: tuple[float, float] = (0.0, 0.0)

    def merged(self, other: ModalPeaks) -> ModalPeaks:
        """The larger of both."""
        return ModalPeaks(
            max(self.stress, other.stress), max(self.rotation, other.rotation), max(self.spin, other.spin)
        )


@dataclass(frozen=True, eq=False)
class _Limits:
    """Of a modal part; a quantity without a limit is not computed.

    yield_stress, whose : Pa, and the part that it is of
    of_modes : (k, N, l, 6) stress per coordinate, or None
    turns : (3 P, k) rotation vectors per coordinate, or None
    spin : rad/s
    """

    part: ModalSubdomain
    yield_stress: float
    whose: str
    of_modes: FloatArray | None
    turns: FloatArray | None
    spin: float


@dataclass(frozen=True, eq=False)
class ModalWatch:
    """The limits of the modal parts of a system, and how to hold them."""

    validity: Validity
    limits: tuple[_Limits, ...]

    def observe(self, so_far: Mapping[str, ModalPeaks], leg: Solution) -> dict[str, ModalPeaks]:
        """The peaks with a leg of a run included; ValidityError at once when strict."""
        merged = {
            own.part.name: so_far.get(own.part.name, ModalPeaks()).merged(
                _peaks(own, leg.times, leg.bodies[own.part.name])
            )
            for own in self.limits
        }
        if self.validity.strict:
            for message in self.excesses(merged):
                raise ValidityError(message)
        return merged

    def excesses(self, peaks: Mapping[str, ModalPeaks]) -> list[str]:
        """What is to be said of every limit passed."""
        found = []
        for own in self.limits:
            peak = peaks.get(own.part.name, ModalPeaks())
            if peak.stress[0] > own.yield_stress:
                found.append(_yields(own, *peak.stress))
            if peak.rotation[0] > ROTATION_LIMIT:
                found.append(_turns(own, *peak.rotation))
            if peak.spin[0] > own.spin:
                found.append(_spins(own, *peak.spin))
        return found

    def report(self, peaks: Mapping[str, ModalPeaks]) -> None:
        """Warn of every limit passed."""
        for message in self.excesses(peaks):
            warnings.warn(message, ValidityWarning, stacklevel=3)


def modal_watch(system: ExplicitSystem, validity: Validity) -> ModalWatch:
    """Prepare the limits of the modal parts of a system.

    The yield stress of a part that states none is the lowest of the explicit parts of its material.
    """
    parts = [part.subdomain for part in system.placed if isinstance(part.subdomain, ModalSubdomain)]
    return ModalWatch(validity, tuple(_limits(system, part, validity) for part in parts if part.n_modes))


def _limits(system: ExplicitSystem, part: ModalSubdomain, validity: Validity) -> _Limits:
    body = part.body
    limit, whose = _yield_stress(system, part)
    turns = None if body.rotation_operator is None else body.rotation_operator @ body.expansion @ part.vectors
    return _Limits(
        part,
        limit,
        whose,
        stress_of_modes(part) if body.model is not None and np.isfinite(limit) else None,
        turns,
        np.inf if part.spin_stiffness is not None else validity.spin_ratio * float(part.frequencies[0]),
    )


def _yield_stress(system: ExplicitSystem, part: ModalSubdomain) -> tuple[float, str]:
    if part.yield_stress is not None:
        return part.yield_stress, part.name
    own = isotropic_materials(part.body.model) if part.body.model else set()
    laws = [(placed.name, getattr(placed.subdomain, "law", None)) for placed in system.placed]
    yields = [
        (float(law.hardening.yield_stress(jnp.zeros(()))), name)
        for name, law in laws
        if isinstance(law, J2Plasticity) and own == {law.elastic}
    ]
    return min(yields, default=(np.inf, part.name))


def _peaks(own: _Limits, times: FloatArray, motion: FourPointMotion) -> ModalPeaks:
    stress, rotation = (0.0, 0.0, 0), (0.0, 0.0)
    if own.of_modes is not None:
        values = modal_von_mises(own.of_modes, motion.coordinates)
        row, node = np.unravel_index(values.argmax(), values.shape)
        stress = float(values[row, node]), float(times[row]), int(node)
    if own.turns is not None:
        vectors = (motion.coordinates @ own.turns.T).reshape(len(times), -1, 3)
        angles = np.sqrt((vectors**2).sum(axis=2).max(axis=1))
        rotation = float(angles.max()), float(times[angles.argmax()])
    P, rates = (points[:, 1:] - points[:, :1] for points in (motion.points, motion.point_rates))
    W = P @ rates.swapaxes(1, 2) / own.part.points.arm**2
    spins = 0.5 * np.linalg.norm(
        np.stack([W[:, i, j] - W[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))]), axis=0
    )
    return ModalPeaks(stress, rotation, (float(spins.max()), float(times[spins.argmax()])))


def _yields(own: _Limits, stress: float, time: float, node: int) -> str:
    name, model = own.part.name, own.part.body.model
    assert model is not None  # of which the stress is
    whose = (
        "its yield stress"
        if own.whose == name
        else f"the yield stress of '{own.whose}', of the same material,"
    )
    return (
        f"part '{name}' is modal, so elastic, and reaches a von Mises stress of {stress:.4g} at node "
        f"{model.mesh.node_ids[node]} (t = {time:.4g}), above {whose} {own.yield_stress:.4g}: it would yield "
        "there. March that region in explicit elements, or state another yield_stress of the modal part"
    )


def _turns(own: _Limits, angle: float, time: float) -> str:
    return (
        f"part '{own.part.name}' is modal and turns by {angle:.3f} rad against its frame (t = {time:.4g}); "
        f"its modes hold to about {ROTATION_LIMIT:g} rad. March it in explicit elements, or as several modal "
        "parts tied to each other"
    )


def _spins(own: _Limits, spin: float, time: float) -> str:
    lowest = float(own.part.frequencies[0])
    return (
        f"part '{own.part.name}' is modal and spins at {spin:.4g} rad per unit of time (t = {time:.4g}), "
        f"{spin / lowest:.2f} times its lowest frequency {lowest:.4g}: its modes are those at rest, softer "
        "than in the spin. Give it stiffening=CentrifugalStiffness() (spin_stiffness = true in a case file)"
    )

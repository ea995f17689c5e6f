"""Fatigue damage at the nodes of a body, from its stress modes and the history of its coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from supple.arguments import Positive, check_fields, checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fatigue import Goodman, Residue, SNCurve, miner_damage, rainflow
from supple.fem import von_mises
from supple.quantities.tensor_modes import STRESS, TensorModes, principal_values

__all__ = ["CriticalPlane", "SignedVonMises", "StressCriterion", "hot_spot_damage"]


_NUMBERS = 2**22
"""Largest number of history values in memory at a time (32 MiB)."""


class StressCriterion(Protocol):
    """Scalar histories, computed from the history of a stress tensor, whose cycles cause damage."""

    @property
    def n_histories(self) -> int:
        """Number of histories per tensor, h; the one with the largest damage counts."""
        ...

    def histories(self, stress: FloatArray) -> FloatArray:
        """Histories (t, k, h) from stresses (t, k, 6) at k points, components xx yy zz yz xz xy."""
        ...


@dataclass(frozen=True)
class CriticalPlane:
    """Stress normal to planes of many directions; the plane with the largest damage counts.

    Valid also if principal axes rotate or components are out of phase, where a signed equivalent stress
    jumps. The nearest plane deviates by at most `spacing` / sqrt(2) rad. The range of a uniaxial stress is
    too small; its relative error is at most the square of this angle: 1.5 % at a spacing of 10 degrees.

    spacing : angle between neighbouring normals of planes, rad
    """

    spacing: Positive = float(np.radians(10.0))

    def __post_init__(self) -> None:
        check_fields(self)
        if not 0 < self.spacing <= np.radians(45.0):
            raise ModelError(
                f"CriticalPlane: spacing is in rad, above 0 and at most pi/4, got {self.spacing:g}"
            )

    @property
    def n_histories(self) -> int:
        """Number of planes."""
        return len(self.normals)

    @property
    def normals(self) -> FloatArray:
        """Unit vectors (h, 3) on half a sphere: circles of latitude with equally spaced vectors."""
        n_rings = int(np.ceil(0.5 * np.pi / self.spacing))
        latitudes = np.linspace(0.0, 0.5 * np.pi, n_rings + 1)
        rings = []
        for latitude in latitudes:
            # Normals on one half of the equator are opposite to those on the other half.
            whole_turn = np.pi if latitude == 0 else 2 * np.pi
            number = max(1, int(np.ceil(whole_turn * np.cos(latitude) / self.spacing - 1e-9)))
            turn = np.arange(number) * whole_turn / number
            ring = [np.cos(turn) * np.cos(latitude), np.sin(turn) * np.cos(latitude)]
            rings.append(np.stack([*ring, np.full(number, np.sin(latitude))], axis=1))
        return np.concatenate(rings)

    def histories(self, stress: FloatArray) -> FloatArray:
        """Normal stress n . sigma n (t, k, h) from stresses (t, k, 6)."""
        x, y, z = self.normals.T
        return stress @ np.stack([x * x, y * y, z * z, 2 * y * z, 2 * x * z, 2 * x * y])


@dataclass(frozen=True)
class SignedVonMises:
    """Von Mises stress with the sign of the principal stress of largest magnitude: one history per tensor.

    For stress whose components stay proportional and that is nearly uniaxial. If the sign changes at large
    shear, the history jumps and the damage is overestimated. Suitable for a quick search of nodes to be
    assessed by `CriticalPlane`.
    """

    n_histories: ClassVar[int] = 1

    def histories(self, stress: FloatArray) -> FloatArray:
        """(t, k, 1) from stresses (t, k, 6)."""
        principal = principal_values(stress)
        sign = np.where(principal[..., 2] >= -principal[..., 0], 1.0, -1.0)
        return (sign * von_mises(stress))[..., None]


@checked_arguments
def hot_spot_damage(
    modes: TensorModes,
    coordinates: ArrayLike,
    curve: SNCurve,
    criterion: StressCriterion = CriticalPlane(),
    *,
    residue: Residue = Residue.HALF_CYCLES,
    correction: Goodman | None = None,
) -> FloatArray:
    """Fatigue damage (N,) at nodes by a history, the largest over the layers and histories of the criterion.

        sigma(t) = modes.at(q(t)),    s_h = histories(sigma),    D = max_h sum_i n_i / N(S_i)

    with n_i cycles of the stress range S_i in history h, and N(S_i) cycles to failure.

    Nodes are processed in blocks: memory does not grow with the number of nodes, but must contain all
    histories of one node.

    Parameters
    ----------
    modes : result of `stress_modes`
    coordinates : (t, r) of the body over time
    curve : S-N curve in the unit of the stress; of a class for the stress in the mesh, without the notch
        effect of welds that are not modelled
    criterion : `CriticalPlane` or `SignedVonMises`

    Raises
    ------
    ModelError      coordinates of the wrong number or not finite, modes of strain, a peak beyond the ultimate
                    stress of `correction`

    Source: DNVGL-RP-C203 (2016), sections 2 and 4; critical planes: Socie and Marquis, Multiaxial Fatigue
    (SAE, 2000).
    """
    history = np.asarray(coordinates, dtype=np.float64)
    if history.ndim != 2:
        raise ModelError(f"hot_spot_damage: expected coordinates (t, r), got shape {history.shape}")
    if modes.tensor is not STRESS:
        raise ModelError("hot_spot_damage: these are modes of strain; give those of `stress_modes`")
    outer = modes.outer_layers()
    per_node = max(1, len(history) * outer.linear.shape[1] * max(6, criterion.n_histories))
    step = max(1, _NUMBERS // per_node)
    damage = np.empty(len(modes.nodes))
    for first in range(0, len(damage), step):
        some = slice(first, first + step)
        stress = outer.of(some).at(history)
        histories = criterion.histories(stress.reshape(len(history), -1, 6))
        found = miner_damage(rainflow(histories, residue), curve, correction)
        damage[some] = found.reshape(len(modes.nodes[some]), -1).max(axis=1)
    return damage

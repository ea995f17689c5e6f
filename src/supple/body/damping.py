"""Damping of a body's deformation, as frozen options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse

from supple.algebra import lowest_modes, read_only
from supple.errors import ModelError


@dataclass(frozen=True)
class RayleighDamping:
    """Kelvin and Voigt's material with a drag on the motion in the frame: D(q) = alpha M + beta K_mat(q).

        K_mat(q) = sum w A^T C A,     eps_dot = A(q) q_dot

    is the stiffness of the material where it stands now, so that beta resists the rate of strain and no
    rotation. At rest it is Rayleigh's alpha M + beta K, of modal ratio
    zeta(omega) = alpha / (2 omega) + beta omega / 2. Alpha resists motion against the body's frame, and so
    depends on the frame.

    alpha in 1/s, beta in s; neither negative.
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        _check_factors("Rayleigh damping", self.alpha, self.beta)

    def matrix(self, stiffness: Any, mass: Any) -> Any:
        """D(0) (n, n), sparse or dense as the matrices given."""
        return self.alpha * mass + self.beta * stiffness

    @property
    def retardation_time(self) -> float:
        """Viscous stress over the stress of the same strain in one second: beta, s."""
        return self.beta

    def linearized(self) -> LinearRayleighDamping:
        """The damping of the undeformed body, whatever its deformation."""
        return LinearRayleighDamping(self.alpha, self.beta)


@dataclass(frozen=True)
class LinearRayleighDamping:
    """C = alpha M + beta K with the stiffness of the undeformed body, for comparison with the literature.

    Where a part of a stiff body has turned against the frame by theta, beta K resists its turning on with
    forces of order theta^2; RayleighDamping does not.

    alpha in 1/s, beta in s; neither negative.
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        _check_factors("linear Rayleigh damping", self.alpha, self.beta)

    def matrix(self, stiffness: Any, mass: Any) -> Any:
        """C (n, n), sparse or dense as the matrices given."""
        return self.alpha * mass + self.beta * stiffness

    @property
    def retardation_time(self) -> float:
        """None: this damping does not follow the strain rate."""
        return 0.0


def _check_factors(what: str, alpha: float, beta: float) -> None:
    for name, value in (("alpha", alpha), ("beta", beta)):
        if not (np.isfinite(value) and value >= 0):
            raise ModelError(f"{what}: {name} is {value}; it must be zero or positive")


def rayleigh_from_ratios(
    ratio: float | tuple[float, float], omega_1: float, omega_2: float
) -> RayleighDamping:
    """Rayleigh damping with given ratios (one for both, or one each) at two frequencies in rad/s.

        zeta_i = alpha / (2 omega_i) + beta omega_i / 2,     i = 1, 2

    Raises
    ------
    ModelError   frequencies not positive and distinct; ratios that need a negative alpha or beta
    """
    if not (np.isfinite(omega_1) and np.isfinite(omega_2) and 0 < omega_1 != omega_2 > 0):
        raise ModelError(
            f"Rayleigh damping needs two distinct positive frequencies, not {omega_1} and {omega_2}"
        )
    omega = np.array([omega_1, omega_2])
    alpha, beta = np.linalg.solve(np.column_stack([0.5 / omega, 0.5 * omega]), np.broadcast_to(ratio, 2))
    return RayleighDamping(float(alpha), float(beta))


def rayleigh_at_modes(
    stiffness: sparse.sparray, mass: sparse.sparray, constraint: Any, ratio: float, modes: tuple[int, int]
) -> RayleighDamping:
    """Rayleigh damping with one ratio on two modes of a body that a constraint holds; their numbers from 1.

    stiffness, mass, constraint : as for `lowest_modes`
    Raises ModelError as for `rayleigh_from_ratios`.
    """
    found = lowest_modes(stiffness, mass, max(modes), constraint=constraint)
    first, second = (float(np.sqrt(found.values[mode - 1])) for mode in modes)
    return rayleigh_from_ratios(ratio, first, second)


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """A damping ratio for each mode of the body as it is simulated; its matrix does not change.

    The modes are motions against the body's frame, so that the damping depends on the frame.

    ratios : one for all modes, or one per mode from the lowest up; modes beyond the last take the last ratio
    """

    ratios: NDArray[np.float64] | float

    def __post_init__(self) -> None:
        ratios = read_only(np.atleast_1d(np.asarray(self.ratios, dtype=np.float64)))
        if ratios.ndim != 1 or ratios.size == 0 or not np.all(np.isfinite(ratios) & (ratios >= 0)):
            raise ModelError(f"modal damping ratios must be zero or positive numbers, not {self.ratios}")
        object.__setattr__(self, "ratios", ratios)

    @property
    def retardation_time(self) -> float:
        """None: this damping does not follow the strain rate."""
        return 0.0

    def matrix(self, stiffness: ArrayLike, mass: ArrayLike) -> NDArray[np.float64]:
        """C = M Phi diag(2 zeta omega) Phi^T M from the modes of dense matrices (r, r)."""
        M = np.asarray(mass, dtype=np.float64)
        squares, modes = linalg.eigh(np.asarray(stiffness, dtype=np.float64), M)
        given = np.asarray(self.ratios)
        ratios = given[np.minimum(np.arange(squares.size), given.size - 1)]
        weighted = M @ modes
        return (weighted * (2 * ratios * np.sqrt(np.maximum(squares, 0)))) @ weighted.T


Damping = RayleighDamping | LinearRayleighDamping | ModalDamping

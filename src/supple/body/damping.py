"""Damping of a body's deformation: Rayleigh damping and modal damping."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse

from supple.algebra import lowest_modes, read_only
from supple.arguments import check_fields, check_numbers
from supple.body.flexible_body import FlexibleBody
from supple.body.frame import NodalFixedFrame, frame_projector
from supple.errors import ModelError

__all__ = [
    "Damping",
    "LinearRayleighDamping",
    "ModalDamping",
    "RayleighDamping",
    "rayleigh_at_modes",
    "rayleigh_from_ratios",
]


@dataclass(frozen=True)
class _OfMassAndStiffness:
    """Damping matrix alpha P^T M P + beta K of the undeformed body; fields as for `RayleighDamping`."""

    alpha: float
    beta: float
    held: str | None = None

    called: ClassVar[str]
    """Name for messages."""

    def __post_init__(self) -> None:
        check_fields(self)
        for name, value in (("alpha", self.alpha), ("beta", self.beta)):
            if not (np.isfinite(value) and value >= 0):
                raise ModelError(f"{self.called}: {name} is {value}; it must be zero or positive")

    def matrix(self, stiffness: Any, mass: Any) -> Any:
        """D (n, n) of the undeformed body, from the stiffness K and `mass` = P^T M P; sparse if they are."""
        return self.alpha * mass + self.beta * stiffness


@dataclass(frozen=True)
class RayleighDamping(_OfMassAndStiffness):
    """Rayleigh damping in the deformed body: damping matrix D(q) = alpha P^T M P + beta K_mat(q).

        K_mat(q) = sum w A^T C A,     eps_dot = A(q) q_dot,     zeta = alpha / (2 omega) + beta omega / 2

    M is the mass matrix. K_mat is the material stiffness in the current configuration q, a sum over the
    integration points; w is the weight of a point and C the elasticity. The term with beta is that of a
    Kelvin-Voigt material: it damps the strain rates eps_dot, and does not resist a rigid rotation of a part.
    P subtracts the rigid motion of the interface `held`. The damping is then the same in every frame, and
    zeta is the damping ratio of a mode of angular frequency omega of the undeformed body, clamped at `held`.
    Without `held`, P is the identity: alpha damps motion relative to the body's frame, so the damping depends
    on the choice of frame.

    alpha : 1/s, zero or positive
    beta : s, zero or positive
    held : name of an interface of the body; None: no interface
    """

    called: ClassVar[str] = "Rayleigh damping"

    @property
    def retardation_time(self) -> float:
        """Retardation time beta, s: the viscous stress is beta C eps_dot."""
        return self.beta

    def linearized(self) -> LinearRayleighDamping:
        """Damping with the same factors and the constant stiffness of the undeformed body."""
        return LinearRayleighDamping(self.alpha, self.beta, self.held)


@dataclass(frozen=True)
class LinearRayleighDamping(_OfMassAndStiffness):
    """Rayleigh damping with the constant matrix alpha P^T M P + beta K; K: stiffness of the undeformed body.

    In a part of a stiff body that has rotated by theta relative to the frame, beta K resists further rotation
    with forces of order theta^2. The damping force of `RayleighDamping` does not. P, alpha, beta and held are
    defined there.
    """

    called: ClassVar[str] = "linear Rayleigh damping"

    retardation_time: ClassVar[float] = 0.0
    """The damping force is not that of viscous stresses beta C eps_dot."""


def rayleigh_from_ratios(
    ratio: float | tuple[float, float], omega_1: float, omega_2: float
) -> RayleighDamping:
    """Rayleigh damping with given damping ratios zeta_1, zeta_2 at two angular frequencies.

        zeta_i = alpha / (2 omega_i) + beta omega_i / 2,     i = 1, 2

    ratio : (zeta_1, zeta_2), or one number for both
    omega_1, omega_2 : rad/s

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
    stiffness: sparse.csc_array,
    mass: sparse.csc_array,
    constraint: ArrayLike | sparse.sparray,
    ratio: float,
    modes: tuple[int, int],
) -> RayleighDamping:
    """Rayleigh damping that gives two modes of a constrained body the same damping ratio.

    stiffness, mass, constraint : as for `lowest_modes`
    ratio : damping ratio of both modes
    modes : numbers of the modes, the lowest is 1
    Raises ModelError as for `rayleigh_from_ratios`.
    """
    found = lowest_modes(stiffness, mass, max(modes), constraint=constraint)
    first, second = (float(np.sqrt(found.values[mode - 1])) for mode in modes)
    return rayleigh_from_ratios(ratio, first, second)


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """Modal damping: a damping ratio zeta for each mode of the undeformed body; constant damping matrix C.

        C = P^T M Phi diag(2 zeta omega) Phi^T M P

    The columns of Phi are the modes of the reduced or full body with the interface `held` clamped,
    normalised to the mass matrix M; omega are their angular frequencies. P subtracts the rigid motion of this
    interface, so that the damping is the same in every frame. Without `held`, Phi are the modes with the
    body's frame fixed, P is the identity, and the damping depends on the choice of frame.

    ratios : damping ratios of the modes, lowest mode first; modes beyond the last ratio have the last ratio
    n_modes : number of damped modes, lowest first; None: all modes, possible only for a reduced body
    held : name of an interface of the body; None: no interface
    """

    ratios: NDArray[np.float64] | float
    n_modes: int | None = None
    held: str | None = None

    def __post_init__(self) -> None:
        check_fields(self)
        check_numbers("ModalDamping, ratios", self.ratios)
        ratios = read_only(np.atleast_1d(np.asarray(self.ratios, dtype=np.float64)))
        if ratios.ndim != 1 or ratios.size == 0 or not np.all(np.isfinite(ratios) & (ratios >= 0)):
            raise ModelError(f"modal damping ratios must be zero or positive numbers, not {self.ratios}")
        if self.n_modes is not None and self.n_modes < 1:
            raise ModelError(f"modal damping: n_modes is {self.n_modes}; damp at least one mode")
        object.__setattr__(self, "ratios", ratios)

    retardation_time: ClassVar[float] = 0.0
    """The damping force is not that of viscous stresses beta C eps_dot."""

    def of_modes(self, n: int) -> NDArray[np.float64]:
        """Damping ratios of the damped modes of a body with n modes."""
        given, damped = np.asarray(self.ratios), np.arange(n)[: self.n_modes]
        return given[np.minimum(damped, given.size - 1)]

    def matrix(self, stiffness: ArrayLike, mass: ArrayLike) -> NDArray[np.float64]:
        """C (r, r) of a reduced body, from its K and `mass` = P^T M P, both (r, r) and dense."""
        M = np.asarray(mass, dtype=np.float64)
        squares, modes = linalg.eigh(np.asarray(stiffness, dtype=np.float64), M)
        columns = self._columns(squares, modes, M)
        return columns @ columns.T

    def columns(
        self, stiffness: sparse.csc_array, mass: sparse.csc_array, constraint: ArrayLike | sparse.sparray
    ) -> NDArray[np.float64]:
        """Factor W (n, n_modes) of C = W W^T of a full body without `held`, from its lowest modes.

        stiffness, mass, constraint : as for `lowest_modes`
        Raises ModelError if `n_modes` is None, or exceeds the number of modes.
        """
        if self.n_modes is None:
            raise ModelError(
                "modal damping of a full body: give the number of damped modes, for "
                "example ModalDamping(0.02, n_modes=20); or take RayleighDamping"
            )
        found = lowest_modes(stiffness, mass, self.n_modes, constraint=constraint)
        return self._columns(found.values, found.vectors, mass)

    def _columns(
        self,
        squares: NDArray[np.float64],
        modes: NDArray[np.float64],
        mass: NDArray[np.float64] | sparse.csc_array,
    ) -> NDArray[np.float64]:
        """M phi sqrt(2 zeta omega) of the damped modes."""
        ratios = self.of_modes(len(squares))
        omega = np.sqrt(np.maximum(squares[: len(ratios)], 0))
        return (mass @ modes[:, : len(ratios)]) * np.sqrt(2 * ratios * omega)


Damping = RayleighDamping | LinearRayleighDamping | ModalDamping


def refuse_relative_damping(damping: Damping | None, what: str) -> None:
    """Raise ModelError if the damping has an interface `held`; `held` requires a floating frame."""
    if damping is not None and damping.held is not None:
        raise ModelError(
            f"{what}: its damping is relative to the interface '{damping.held}', which needs a body in a "
            "floating frame; leave held out"
        )


def damping_matrix(
    damping: Damping | None, body: FlexibleBody, columns: NDArray[np.float64], stiffness: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Damping matrix D (k, k) of an undeformed body whose motion is V g, for the k coordinates g.

    damping : None: D is zero
    columns : V (n, k), M-orthonormal; the mass matrix in D is V^T P^T M P V, the unit matrix without `held`
    stiffness : V^T K V (k, k)
    Raises ModelError if the interface `held` is not in the body, or does not fix its rigid motion.
    """
    mass = np.eye(columns.shape[1])
    if damping is None:
        return 0.0 * mass
    if damping.held is not None:
        seen = frame_projector(body, NodalFixedFrame(damping.held))(columns)
        mass = seen.T @ (body.mass @ seen)
    return damping.matrix(stiffness, mass)

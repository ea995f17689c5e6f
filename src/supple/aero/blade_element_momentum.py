"""Blade-element momentum: air loads along a blade from the balance of momentum in annular stream tubes."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.aero.polar import BlendedPolars
from supple.aero.rotor import Rotor
from supple.arrays import FloatArray
from supple.errors import ConvergenceError, ModelError

__all__ = ["AirLoads", "Operation", "air_loads", "rotor_power", "rotor_thrust"]

# Axial induction above which Glauert's empirical line replaces momentum theory.
CRITICAL_INDUCTION = 0.2
# Smallest value of the tip-loss factor F in divisions; F is zero at the tip.
LEAST_TIP_LOSS = 1e-6
SMALLEST_INFLOW_ANGLE = 1e-6
INFLOW_TOLERANCE = 1e-11


@dataclass(frozen=True, kw_only=True)
class Operation:
    """Operation of a rotor: angular speed, rad/s; pitch, rad; density of air, kg/m^3.

    A positive pitch rotates the nose into the wind.
    """

    angular_speed: float
    pitch: float
    air_density: float = 1.225

    def __post_init__(self) -> None:
        if not (isfinite(self.angular_speed) and self.angular_speed > 0):
            raise ModelError(f"angular speed {self.angular_speed} rad/s; give a rotating rotor")
        if not isfinite(self.pitch):
            raise ModelError(f"pitch {self.pitch} rad; give a number")
        if not (isfinite(self.air_density) and self.air_density > 0):
            raise ModelError(f"air density {self.air_density} kg/m^3; give a value above zero")


@dataclass(frozen=True)
class AirLoads:
    """Loads on one blade, and the flow at its sections; all arrays (..., k) over k radii."""

    normal: FloatArray
    """Force per length along the wind, N/m."""
    tangential: FloatArray
    """Force per length that drives the rotor, N/m."""
    angle_of_attack: FloatArray
    """rad"""
    axial_induction: FloatArray
    tangential_induction: FloatArray


def air_loads(rotor: Rotor, operation: Operation, *, radius: ArrayLike, wind: ArrayLike) -> AirLoads:
    """Loads per length on a blade in axial wind, with Prandtl's tip loss and Glauert's line for high loading.

    At a section with radius r, chord c and inflow angle phi, the angle of attack is alpha = phi - twist -
    pitch. With B blades of tip radius R, and s = B c / (2 pi r),
        C_n = C_l cos phi + C_d sin phi,     C_t = C_l sin phi - C_d cos phi,
        F = 2/pi acos exp(-B/2 (R - r) / (r sin phi)),
        k = s C_n / (4 F sin^2 phi),         k' = s C_t / (4 F sin phi cos phi).
    The balance of momentum gives 1/(1 - a) = 1 + k and 1/(1 + a') = 1 - k' for the axial and tangential
    induction a and a'. For a > a_c = 0.2 the thrust coefficient is 4 F (a_c^2 + (1 - 2 a_c) a), that is,
    1/(1 - a) = ((b^2 + 4 k d^2)^(1/2) + b) / (2 d^2), b = 1 - 2 a_c, d = 1 - a_c. The inflow angle is the
    root of
        sin phi / (1 - a) omega r - cos phi / (1 + a') V = 0
    in (0, pi/2]. It is found by bracketing, because fixed-point iteration diverges at high tip-speed ratios.
    In this form the function is finite and continuous in (0, pi/2]. If the section has drag, the function
    is negative near phi = 0.
    With the air density rho and the relative wind speed W,
        F_N = rho/2 W^2 c C_n,   F_T = rho/2 W^2 c C_t,   W^2 = (V (1 - a))^2 + (omega r (1 + a'))^2.

    Parameters
    ----------
    radius : float array (k,)       m
    wind : float array (..., k)     undisturbed axial wind V at these radii, m/s, above zero
    Returns
    -------
    AirLoads   (..., k)
    Raises
    ------
    ModelError         radius off the blade, wind not above zero, angle of attack that a polar does not cover
    ConvergenceError   no inflow angle in (0, pi/2] balances the momentum (the rotor drives the air)
    Source: [Hansen2015], chapter 6; residual without singular points after [Ning2014].
    """
    radius, wind = rotor.on_blade(radius), np.asarray(wind, dtype=np.float64)
    polars = rotor.polars_at(radius)
    bad = np.argwhere(~((wind > 0) & np.isfinite(wind)))
    if bad.size:
        raise ModelError(
            f"wind {wind[tuple(bad[0])]} m/s at {_where(bad[0], radius)}; give a finite value above zero"
        )
    section = _Sections(rotor, operation, radius, polars)

    from scipy.optimize.elementwise import find_root

    found = find_root(
        section.residual,
        (np.full(wind.shape, SMALLEST_INFLOW_ANGLE), np.full(wind.shape, np.pi / 2)),
        args=(np.broadcast_to(np.arange(radius.size), wind.shape), wind),
        tolerances={"xatol": INFLOW_TOLERANCE, "xrtol": 0.0, "fatol": 0.0, "frtol": 0.0},
    )
    bad = np.argwhere(~found.success)
    if bad.size:
        raise ConvergenceError(
            f"no inflow angle between 0 and 90 deg balances the momentum at {_where(bad[0], radius)}, wind "
            f"{wind[tuple(bad[0])]:g} m/s: the rotor drives the air; lower the angular speed or the pitch"
        )
    return section.loads(found.x, np.broadcast_to(np.arange(radius.size), wind.shape), wind)


@dataclass(frozen=True)
class _Sections:
    """The blade's sections at k radii, and their loads at given inflow angles."""

    rotor: Rotor
    operation: Operation
    radius: FloatArray
    polars: BlendedPolars

    def chord(self) -> FloatArray:
        """Chord at all radii, m."""
        return np.interp(self.radius, self.rotor.radius, self.rotor.chord)

    def angle_of_attack(self, phi: FloatArray, place: NDArray[np.int64]) -> FloatArray:
        """Angle of attack, rad, of the sections with numbers `place`."""
        twist = np.interp(self.radius, self.rotor.radius, self.rotor.twist)
        return phi - twist[place] - self.operation.pitch

    def coefficients(self, phi: FloatArray, place: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
        """C_n and C_t."""
        lift, drag = self.polars.coefficients(place, self.angle_of_attack(phi, place))
        return lift * np.cos(phi) + drag * np.sin(phi), lift * np.sin(phi) - drag * np.cos(phi)

    def slowing(self, phi: FloatArray, place: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
        """1/(1 - a), and cos(phi)/(1 + a'), which stays finite at phi = pi/2."""
        C_n, C_t = self.coefficients(phi, place)
        sin, cos, r = np.sin(phi), np.cos(phi), self.radius[place]
        n = self.rotor.n_blades
        tip_loss = 2 / np.pi * np.arccos(np.exp(-n / 2 * (self.rotor.tip_radius - r) / (r * sin)))
        solidity = n * self.chord()[place] / (2 * np.pi * r)
        share = solidity / (4 * np.maximum(tip_loss, LEAST_TIP_LOSS) * sin)
        k = share * C_n / sin
        b, d = 1 - 2 * CRITICAL_INDUCTION, 1 - CRITICAL_INDUCTION
        turbulent = (np.sqrt(b**2 + 4 * np.maximum(k, 0) * d**2) + b) / (2 * d**2)
        return np.where(k <= CRITICAL_INDUCTION / d, 1 + k, turbulent), cos - share * C_t

    def residual(self, phi: FloatArray, place: NDArray[np.int64], wind: FloatArray) -> FloatArray:
        """Residual, m/s, of the equation whose root phi is the inflow angle."""
        axial, tangential = self.slowing(phi, place)
        return np.sin(phi) * axial * self.operation.angular_speed * self.radius[place] - tangential * wind

    def loads(self, phi: FloatArray, place: NDArray[np.int64], wind: FloatArray) -> AirLoads:
        """Loads of the sections with numbers `place`; ModelError for angles that a polar does not cover."""
        angle = self.angle_of_attack(phi, place)
        self._check_covered(angle, place)
        C_n, C_t = self.coefficients(phi, place)
        axial, tangential = self.slowing(phi, place)
        turning = np.cos(phi) / tangential
        W2 = (wind / axial) ** 2 + (self.operation.angular_speed * self.radius[place] * turning) ** 2
        pressure = self.operation.air_density / 2 * W2 * self.chord()[place]
        return AirLoads(pressure * C_n, pressure * C_t, angle, 1 - 1 / axial, turning - 1)

    def _check_covered(self, angle: FloatArray, place: NDArray[np.int64]) -> None:
        lowest, highest = self.polars.lowest[place], self.polars.highest[place]
        bad = np.argwhere((angle < lowest) | (angle > highest))
        if bad.size:
            at = tuple(bad[0])
            raise ModelError(
                f"angle of attack {np.degrees(angle[at]):.2f} deg at {_where(bad[0], self.radius)} is not "
                f"covered: the polars there run from {np.degrees(lowest[at]):.2f} to "
                f"{np.degrees(highest[at]):.2f} deg; extend them"
            )


def _where(index: NDArray[np.int64], radius: FloatArray) -> str:
    row = f", row {', '.join(map(str, index[:-1]))} of the wind" if index.size > 1 else ""
    return f"radius {radius[index[-1]]:g} m{row}"


def rotor_power(rotor: Rotor, operation: Operation, *, radius: ArrayLike, loads: AirLoads) -> FloatArray:
    """Power P = B omega int F_T r dr, (...) W, by the trapezoidal rule; the radii must span the blade."""
    radius = np.asarray(radius, dtype=np.float64)
    torque = np.trapezoid(loads.tangential * radius, radius, axis=-1)
    return np.asarray(rotor.n_blades * operation.angular_speed * torque)


def rotor_thrust(rotor: Rotor, *, radius: ArrayLike, loads: AirLoads) -> FloatArray:
    """Thrust T = B int F_N dr, (...) N, by the trapezoidal rule; the radii must span the blade."""
    radius = np.asarray(radius, dtype=np.float64)
    return np.asarray(rotor.n_blades * np.trapezoid(loads.normal, radius, axis=-1))

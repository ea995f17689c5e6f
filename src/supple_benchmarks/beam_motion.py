"""Motion of the geometrically exact planar beam: driven at its root, or flying freely."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import numpy as np
from scipy.linalg import solve_banded

from supple.errors import ConvergenceError, ModelError
from supple_benchmarks.planar_beam import BANDWIDTH, NODE_SIZE, Array, BeamElements, PlanarBeam

MAX_ITERATIONS = 25


@dataclass(frozen=True)
class BeamMotion:
    """History of a planar beam in the inertial frame.

    Parameters
    ----------
    elements : BeamElements             the discretised beam
    times : array (t,)                  s
    configuration : array (t, N, 3)     x, y and section rotation of the nodes, root first
    velocity : array (t, N, 3)          rates of the configuration
    iterations : int                    Newton iterations of the whole run
    """

    elements: BeamElements
    times: Array
    configuration: Array
    velocity: Array
    iterations: int

    def __post_init__(self) -> None:
        for array in (self.times, self.configuration, self.velocity):
            array.setflags(write=False)

    @property
    def root_angle(self) -> Array:
        """Rotation of the root section (t,), rad."""
        return self.configuration[:, 0, 2]

    def displacement_in_root_frame(self) -> Array:
        """Axial and transverse displacement (t, N, 2) of the nodes, in axes that rotate with the root.

        u + i v = (r - r_root) exp(-i theta_root) - s, as in [Wu2019] (51): along the root's axis, and normal
        to it in the direction in which a positive rotation moves the beam.
        """
        offset = self.configuration[..., :2] - self.configuration[:, :1, :2]
        seen = (offset[..., 0] + 1j * offset[..., 1]) * np.exp(-1j * self.root_angle)[:, None]
        relative = seen - self.elements.arc_length
        return np.stack([relative.real, relative.imag], axis=-1)

    @property
    def tip_axial(self) -> Array:
        """Axial tip displacement (t,) in the root frame."""
        return self.displacement_in_root_frame()[:, -1, 0]

    @property
    def tip_transverse(self) -> Array:
        """Transverse tip displacement (t,) in the root frame; negative where the tip lags."""
        return self.displacement_in_root_frame()[:, -1, 1]

    def energy(self) -> Array:
        """Kinetic plus strain energy (t,)."""
        return self.elements.kinetic_energy(self.velocity) + self.elements.strain_energy(self.configuration)

    def linear_momentum(self) -> Array:
        """Linear momentum (t, 2)."""
        return self.elements.momentum(self.velocity)[..., :2].sum(axis=1)

    def angular_momentum(self) -> Array:
        """Angular momentum (t,) about the origin."""
        p = self.elements.momentum(self.velocity)
        x, y = self.configuration[..., 0], self.configuration[..., 1]
        return (x * p[..., 1] - y * p[..., 0] + p[..., 2]).sum(axis=1)


def spin_up_beam(
    beam: PlanarBeam,
    angle: Callable[[jax.Array], jax.Array],
    *,
    duration: float,
    step: float,
    n_elements: int = 20,
    rho_inf: float = 0.8,
    tolerance: float = 1e-9,
) -> BeamMotion:
    """Motion of the beam whose root rotates by a prescribed angle about a fixed point.

    The root section is clamped to a hub at the origin that rotates by theta(t); the beam starts straight and
    in rigid rotation with it. No floating frame is used: the motion is an independent reference for methods
    with a floating frame.

    Parameters
    ----------
    angle : callable          scalar time -> theta, written with jax.numpy, for example SpinUp
    duration, step : float    s; the step is adjusted slightly if it does not divide the duration
    rho_inf : float           spectral radius at infinity of generalized-alpha, in [0, 1]; for 1, axial waves
                              that no practical step resolves grow until Newton's method fails
    tolerance : float         of Newton's iteration, on the residual relative to the internal force

    Raises
    ------
    ModelError          duration, step or rho_inf out of range, or an angle that is not finite
    ConvergenceError    Newton's method failed; the message names the time
    Source: [SimoVuQuoc1986]; time integration [ArnoldBruels2007]
    """
    elements = BeamElements(beam, n_elements)
    times = _time_grid(duration, step)
    root = np.zeros((3, len(times), NODE_SIZE))
    root[..., 2] = angle_history(angle, times)
    start = elements.straight(float(root[0, 0, 2]))
    turning = np.stack([-start[:, 1], start[:, 0], np.ones(len(start))], axis=-1)
    return _integrate(elements, times, start, root[1, 0, 2] * turning, root, rho_inf, tolerance)


def fly_beam(
    elements: BeamElements,
    configuration: Array,
    velocity: Array,
    *,
    duration: float,
    step: float,
    rho_inf: float = 0.8,
    tolerance: float = 1e-9,
) -> BeamMotion:
    """Free flight of the beam from a given configuration and velocity, each (N, 3).

    Energy and momentum are conserved, which tests the integration. Options and errors as for spin_up_beam;
    ModelError also if configuration or velocity does not have shape (N, 3).
    """
    expected = (elements.n_nodes, NODE_SIZE)
    for name, array in (("configuration", configuration), ("velocity", velocity)):
        if array.shape != expected:
            raise ModelError(f"planar beam: the initial {name} has shape {array.shape}, not {expected}")
    times = _time_grid(duration, step)
    free = np.empty((3, len(times), 0))
    return _integrate(elements, times, configuration, velocity, free, rho_inf, tolerance)


def angle_history(angle: Callable[[jax.Array], jax.Array], times: Array) -> Array:
    """Angle, rad, rate and acceleration (3, t) of a traceable law theta(t), with exact derivatives.

    Parameters
    ----------
    angle : callable        scalar time (s) -> scalar angle (rad), written with jax.numpy
    times : array (t,)      s

    Raises
    ------
    ModelError  the law or a derivative is not finite at one of the times
    """
    rate = jax.grad(angle)
    acceleration = jax.grad(rate)
    sample = jax.jit(jax.vmap(lambda time: (angle(time), rate(time), acceleration(time))))
    with jax.enable_x64(True):
        samples = np.array(sample(times))
    finite = np.isfinite(samples).all(axis=0)
    if not finite.all():
        raise ModelError(
            f"the prescribed angle or one of its derivatives is not finite at t = {times[~finite][0]:g} s: "
            "give a law that is smooth over the whole run"
        )
    return samples


def _time_grid(duration: float, step: float) -> Array:
    if not 0.0 < step <= duration < np.inf:
        raise ModelError(f"planar beam: step {step} s and duration {duration} s; need 0 < step <= duration")
    return np.linspace(0.0, duration, max(1, round(duration / step)) + 1)


def _integrate(
    elements: BeamElements,
    times: Array,
    configuration: Array,
    velocity: Array,
    root: Array,
    rho_inf: float,
    tolerance: float,
) -> BeamMotion:
    """Generalized-alpha with equilibrium at the end of each step and auxiliary accelerations a:

    M dv/dt + f(q) = 0,   (1 - alpha_m) a' + alpha_m a = (1 - alpha_f) dv'/dt + alpha_f dv/dt

    Equilibrium at the end of the step allows the prescribed acceleration of the root to enter unchanged.

    root : (3, t, k)    the k prescribed freedoms of the root, their rates and their accelerations
    """
    if not 0.0 <= rho_inf <= 1.0:
        raise ModelError(f"planar beam: rho_inf is {rho_inf}; give a spectral radius in [0, 1]")
    h = times[1] - times[0]
    alpha_m = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0)
    alpha_f = rho_inf / (rho_inf + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (gamma + 0.5) ** 2
    rate_factor = gamma / (h * beta)
    mass_factor = (1.0 - alpha_m) / (h**2 * beta * (1.0 - alpha_f))
    fixed = root.shape[2]

    shape = (elements.n_nodes, NODE_SIZE)
    q, v = configuration.reshape(-1).copy(), velocity.reshape(-1).copy()
    v_dot = _initial_acceleration(elements, q.reshape(shape), root[2, 0])
    a = v_dot.copy()
    configurations, velocities = np.empty((len(times), *shape)), np.empty((len(times), *shape))
    configurations[0], velocities[0] = q.reshape(shape), v.reshape(shape)
    # Round-off of the strains times the axial stiffness: the smallest residual that can be reached.
    floor = 1e-13 * elements.beam.axial_stiffness
    iterations = 0
    error = force = np.inf

    for i in range(1, len(times)):
        # First guess: the previous acceleration.
        a_next = (v_dot - alpha_m * a) / (1.0 - alpha_m)
        q = q + h * v + h**2 * ((0.5 - beta) * a + beta * a_next)
        v = v + h * ((1.0 - gamma) * a + gamma * a_next)
        v_dot_old, v_dot = v_dot, v_dot.copy()
        q[:fixed], v[:fixed], v_dot[:fixed] = root[:, i]
        for _ in range(MAX_ITERATIONS):
            residual, internal, tangent = elements.residual_and_tangent(
                q.reshape(shape), v_dot.reshape(shape), mass_factor
            )
            error, force = float(np.linalg.norm(residual[fixed:])), float(np.linalg.norm(internal))
            if error <= tolerance * force + floor:
                break
            # Without its leading columns, the banded matrix is that of the remaining degrees of freedom.
            correction = solve_banded((BANDWIDTH, BANDWIDTH), tangent[:, fixed:], -residual[fixed:])
            q[fixed:] += correction
            v[fixed:] += rate_factor * correction
            v_dot[fixed:] += mass_factor * correction
            iterations += 1
        else:
            raise ConvergenceError(
                f"planar beam: no equilibrium at t = {times[i]:g} s after {MAX_ITERATIONS} iterations "
                f"(residual {error:.2e}, internal force {force:.2e}): take a smaller step or rho_inf"
            )
        a = ((1.0 - alpha_f) * v_dot + alpha_f * v_dot_old - alpha_m * a) / (1.0 - alpha_m)
        configurations[i], velocities[i] = q.reshape(shape), v.reshape(shape)
    return BeamMotion(elements, times, configurations, velocities, iterations)


def _initial_acceleration(elements: BeamElements, configuration: Array, prescribed: Array) -> Array:
    fixed = len(prescribed)
    acceleration = np.zeros(NODE_SIZE * elements.n_nodes)
    acceleration[:fixed] = prescribed
    known = elements.momentum(acceleration.reshape(configuration.shape)).reshape(-1)
    load = -(elements.internal_force(configuration) + known)
    mass = elements.banded_mass()[:, fixed:]
    acceleration[fixed:] = solve_banded((BANDWIDTH, BANDWIDTH), mass, load[fixed:])
    return acceleration

"""Spatial geometrically exact (Simo-Reissner) beam: three-node elements, statics and generalized-alpha.

Independent of supple on purpose: full rotation matrices at the nodes, no small angles, no floating frame.

    Gamma = R^T r' - e_x,   K = axial(R^T R'),   U = 1/2 int Gamma . C_N Gamma + K . C_M K ds

Rotations between nodes follow from the Rodrigues vectors c = 2 tan(angle / 2) n relative to the middle node:
all expressions are rational and the strains are objective. Two Gauss points avoid locking; Simpson's rule
lumps the inertia at the nodes. Sections are normal to r' in the unloaded beam.

Sources: J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79-116; M. A. Crisfield,
G. Jelenic, Proc. R. Soc. Lond. A 455 (1999) 1125-1147; O. Bruls, A. Cardona, J. Comput. Nonlinear Dyn. 5
(2010) 031002.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
import numpy as np

import supple.algebra.jax_settings  # noqa: F401  (64-bit floats)

POINTS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
SHAPES = jnp.array(np.stack([POINTS * (POINTS - 1) / 2, 1 - POINTS**2, POINTS * (POINTS + 1) / 2], axis=1))
SLOPES = jnp.array(np.stack([POINTS - 0.5, -2 * POINTS, POINTS + 0.5], axis=1))
NEWTON_STEPS = 40
# Largest increment of the last Newton iteration, m and rad.
TOLERANCE = 1e-9


def rotation(c):
    """Rotation matrices (..., 3, 3) of Rodrigues vectors (..., 3)."""
    cross = jnp.cross(jnp.eye(3), c[..., None, :])
    scale = (1 + (c * c).sum(-1) / 4)[..., None, None]
    return jnp.eye(3) + (cross + cross @ cross / 2) / scale


def rodrigues_vector(R):
    """Rodrigues vectors (..., 3) of rotations (..., 3, 3) by less than half a turn."""
    axial = jnp.stack(
        [R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], -1
    )
    return 2 * axial / (1 + jnp.trace(R, axis1=-2, axis2=-1))[..., None]


@dataclass(frozen=True, eq=False)
class Beam:
    """A beam along N nodes (odd), its root clamped.

    positions (N, 3), axes (N, 3, 3): unloaded; the section's axes are columns, the first along the beam
    stiffness (6,): E A, G A along y and z, G J, E I about y and z
    mass, inertia (3,): per length; about the section's axes
    """

    positions: np.ndarray
    axes: np.ndarray
    stiffness: np.ndarray
    mass: float = 1.0
    inertia: np.ndarray = field(default_factory=lambda: np.ones(3))

    @property
    def free(self):
        """Whether each node is free (N,)."""
        return np.arange(len(self.positions)) > 0

    @property
    def spans(self):
        """Nodes of each element (E, 3)."""
        return 2 * np.arange(len(self.positions) // 2)[:, None] + np.arange(3)

    @property
    def jacobian(self):
        """ds/dxi at the points (E, 2)."""
        return jnp.linalg.norm(jnp.einsum("ga,eai->egi", SLOPES, self.positions[self.spans]), axis=-1)

    @property
    def nodal_length(self):
        """Length that belongs to each node (N,), by Simpson's rule."""
        share = np.asarray(self.jacobian).mean(1)[:, None] * np.array([1.0, 4.0, 1.0]) / 3
        return np.bincount(self.spans.ravel(), share.ravel())


def straight_beam(length, n_elements, stiffness, **inertia):
    """A beam along x with section axes parallel to the global ones."""
    x = np.linspace(0, length, 2 * n_elements + 1)[:, None] * np.eye(3)[0]
    return Beam(x, np.tile(np.eye(3), (len(x), 1, 1)), np.asarray(stiffness), **inertia)


def strains(x, R, jacobian):
    """Gamma + e_x and K at both points, (2, 6), of one element: x (3, 3), R (3, 3, 3)."""
    c_nodes = rodrigues_vector(R[1].T @ R)
    c, dc = SHAPES @ c_nodes, SLOPES @ c_nodes / jacobian[:, None]
    dx = SLOPES @ x / jacobian[:, None]
    Gamma = jnp.einsum("gji,gj->gi", R[1] @ rotation(c), dx)
    K = (dc - jnp.cross(c, dc) / 2) / (1 + (c * c).sum(-1) / 4)[:, None]
    return jnp.concatenate([Gamma, K], axis=1)


def moved(x, R, step):
    """Positions and rotations after increments (N, 6): in space, and about the sections' own axes."""
    return x + step[:, :3], R @ rotation(step[:, 3:])


def element_energy(step, x, R, unloaded, stiffness, jacobian):
    """Strain energy of one element after increments (3, 6)."""
    e = strains(*moved(x, R, step), jacobian) - unloaded
    return 0.5 * (stiffness * e**2 * jacobian[:, None]).sum()


@jax.jit
def force_and_tangent(model, x, R):
    """Internal force (N, 6), moments in section axes, and its tangent (6N, 6N)."""
    stiffness, jacobian, unloaded, spans = model
    given = (jnp.zeros((len(spans), 3, 6)), x[spans], R[spans], unloaded, stiffness, jacobian)
    over = (0, 0, 0, 0, None, 0)
    force = jax.vmap(jax.grad(element_energy), over)(*given)
    tangent = jax.vmap(jax.hessian(element_energy), over)(*given)
    rows = (6 * spans[:, :, None] + jnp.arange(6)).reshape(len(spans), 18)
    total = jnp.zeros((len(x), 6)).at[spans].add(force)
    matrix = jnp.zeros((6 * len(x), 6 * len(x)))
    return total, matrix.at[rows[:, :, None], rows[:, None]].add(tangent.reshape(-1, 18, 18))


def _model(beam):
    unloaded = jax.vmap(strains)(beam.positions[beam.spans], beam.axes[beam.spans], beam.jacobian)
    return jnp.asarray(beam.stiffness), beam.jacobian, unloaded, jnp.asarray(beam.spans)


def bent(beam, load, *, n_steps=10):
    """Equilibrium (x, R) under dead nodal forces and moments (N, 6), raised in equal steps."""
    model, x, R = _model(beam), jnp.asarray(beam.positions), jnp.asarray(beam.axes)
    free = np.repeat(beam.free, 6)
    for share in np.arange(1, n_steps + 1) / n_steps:
        for _ in range(NEWTON_STEPS):
            force, K = (np.array(a) for a in force_and_tangent(model, x, R))
            moment = np.einsum("nji,nj->ni", R, share * load[:, 3:])
            residual = force - np.concatenate([share * load[:, :3], moment], axis=1)
            # A dead moment rotates relative to the section: d(R^T m) = R^T m x d theta.
            blocks = K.reshape(len(x), 6, len(x), 6)
            nodes = np.arange(len(x))
            blocks[nodes, 3:, nodes, 3:] += np.cross(np.eye(3), moment[:, None, :]).swapaxes(1, 2)
            step = np.zeros(residual.size)
            step[free] = np.linalg.solve(K[np.ix_(free, free)], -residual.ravel()[free])
            x, R = moved(x, R, step.reshape(-1, 6))
            if abs(step).max() <= TOLERANCE:
                break
        else:
            raise RuntimeError(f"no equilibrium at {share:g} of the load")
    return np.asarray(x), np.asarray(R)


def swung(beam, tip_force, *, step, rho_inf=0.9):
    """Motion x (t, N, 3), R (t, N, 3, 3), v (t, N, 6) from rest under a dead force (t, 3) at the tip.

    v contains velocities in space and angular velocities about the sections' own axes. Equilibrium holds at
    the end of each step.
    """
    lengths = jnp.asarray(beam.nodal_length)[:, None]
    inertia = lengths * jnp.concatenate([jnp.full(3, beam.mass), jnp.asarray(beam.inertia)])
    start = jnp.asarray(beam.positions), jnp.asarray(beam.axes), jnp.zeros((len(beam.positions), 6))
    history, counts = _march(_model(beam), inertia, beam.free, start, jnp.asarray(tip_force), step, rho_inf)
    if int(counts.max()) >= NEWTON_STEPS:
        raise RuntimeError(f"no equilibrium in step {int(counts.argmax()) + 1}; take a smaller step")
    return tuple(np.concatenate([first[None], rest]) for first, rest in zip(start, history, strict=True))


def energies(beam, x, R, v):
    """Strain energy and kinetic energy of one state."""
    stiffness, jacobian, unloaded, spans = _model(beam)
    given = (jnp.zeros((len(spans), 3, 6)), x[spans], R[spans], unloaded, stiffness, jacobian)
    strain_energy = jax.vmap(element_energy, (0, 0, 0, 0, None, 0))(*given).sum()
    density = np.concatenate([np.full(3, beam.mass), beam.inertia])
    return float(strain_energy), float(0.5 * (beam.nodal_length[:, None] * density * v**2).sum())


def turning(c):
    """Map of increments of displacements and Rodrigues vectors c to motions in section axes: (N, 6, 6)."""
    T = (jnp.eye(3) - jnp.cross(jnp.eye(3), c[:, None]) / 2) / (1 + (c * c).sum(-1) / 4)[:, None, None]
    return jnp.tile(jnp.eye(6), (len(c), 1, 1)).at[:, 3:, 3:].set(T)


@jax.jit
def _march(model, inertia, free_nodes, start, tip_force, step, rho_inf):
    alpha_m, alpha_f = (2 * rho_inf - 1) / (rho_inf + 1), rho_inf / (rho_inf + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = 0.25 * (gamma + 0.5) ** 2
    to_acceleration = (1 - alpha_m) / (beta * step**2 * (1 - alpha_f))
    to_velocity = gamma / (beta * step)
    free = jnp.repeat(free_nodes, 6) * 1.0

    def residual(x, R, v, v_dot, push):
        force, K = force_and_tangent(model, x, R)
        gyroscopic = jnp.cross(v[:, 3:], inertia[:, 3:] * v[:, 3:])
        return inertia * v_dot + force.at[:, 3:].add(gyroscopic).at[-1, :3].add(-push), K

    def advance(state, push):
        x0, R0, v0, v_dot0, a0 = state
        a = (alpha_f * v_dot0 - alpha_m * a0) / (1 - alpha_m)
        increment = step * v0 + step**2 * ((0.5 - beta) * a0 + beta * a)
        v = v0 + step * ((1 - gamma) * a0 + gamma * a)

        def correct(now):
            increment, v, v_dot, _, count = now
            r, K = residual(*moved(x0, R0, increment), v, v_dot, push)
            K = jnp.einsum("ianb,nbc->ianc", K.reshape(*r.shape, *r.shape), turning(increment[:, 3:]))
            K = K.reshape(r.size, -1) + jnp.diag((to_acceleration * inertia).ravel())
            K = K * free[:, None] * free + jnp.diag(1 - free)
            change = -jnp.linalg.solve(K, free * r.ravel()).reshape(r.shape)
            v, v_dot = v + to_velocity * change, v_dot + to_acceleration * change
            return increment + change, v, v_dot, abs(change).max(), count + 1

        def going(now):
            return (now[3] > TOLERANCE) & (now[4] < NEWTON_STEPS)

        now = jax.lax.while_loop(going, correct, (increment, v, jnp.zeros_like(v), jnp.inf, 0))
        increment, v, v_dot, _, count = now
        x, R = moved(x0, R0, increment)
        a = ((1 - alpha_f) * v_dot + alpha_f * v_dot0 - alpha_m * a0) / (1 - alpha_m)
        return (x, R, v, v_dot, a), ((x, R, v), count)

    x, R, v = start
    v_dot = jnp.zeros_like(v).at[-1, :3].set(tip_force[0] / inertia[-1, :3])
    return jax.lax.scan(advance, (x, R, v, v_dot, v_dot), tip_force[1:])[1]

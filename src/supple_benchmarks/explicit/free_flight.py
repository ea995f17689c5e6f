"""A box in free flight on a four-point frame: conservation, order of convergence, and step limit."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax
from jax.typing import ArrayLike

from supple.algebra.rotation import rotation_log
from supple.body import flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, block
from supple.methods.explicit import (
    ModalSubdomain,
    ProjectedDifference,
    PublishedScheme,
    modal_subdomain,
)
from supple.methods.explicit.frame_model import (
    FrameModel,
    FrameState,
    Generalized,
    StepLengths,
    link_residual,
    step_kinetic_energy,
)
from supple.methods.explicit.frame_moments import arms, moments, spread
from supple.methods.explicit.mass_fields import mass_fields
from supple.methods.explicit.step_limit import local_limit, true_limit
from supple.reduction import NormalModes

__all__ = ["angular_momentum", "free_flight", "linear_momentum", "step_limit", "strain_energy"]

Scheme = ProjectedDifference | PublishedScheme
TURN = 5.8e-3
"""Rotation of the box in one step, rad."""


def _moved(model: FrameModel, state: FrameState, h: Array | float) -> tuple[Array, Array, Array]:
    """Points and modes at t_n-1, the start of the step, and sum m xi_a (x_n - x_n-1) / h, (4, 3)."""
    p, y = state.p - h * state.vp, state.y - h * state.vy
    sums = spread(model.moments, y)
    momentum = sums.Xi @ state.vp + (sums.Q @ state.vy) @ arms(state.p).T
    return p, y, momentum


def linear_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m (x_n - x_n-1) / h, (3,)."""
    return _moved(model, state, h)[2].sum(axis=0)


def angular_momentum(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """Sum m x_n-1 x (x_n - x_n-1) / h about the origin of space, (3,)."""
    p, _, momentum = _moved(model, state, h)
    return jnp.cross(p, momentum).sum(axis=0)


def strain_energy(model: FrameModel, state: FrameState, h: Array | float) -> Array:
    """1/2 y_n-1 . K y_n, which leap-frog conserves together with the kinetic energy of the step."""
    return 0.5 * (state.y - h * state.vy) @ (model.stiffness @ state.y)


def _box(n_modes: int) -> ModalSubdomain:
    model = solid_model(block(8, 2, 2, 8, 2, 2, CellType.TETRA4), Isotropic(100.0, 0.3, 1.0))
    return modal_subdomain(flexible_body("box", model), NormalModes(n_modes))


@partial(jax.jit, static_argnums=0)
def _flown(
    scheme: Scheme, model: FrameModel, state: FrameState, before: float, step: float, n: int
) -> FrameState:
    nothing = Generalized(jnp.zeros((4, 3)), jnp.zeros_like(state.y))
    return lax.fori_loop(
        0, n, lambda _, s: scheme.step(model, s, nothing, StepLengths(before, step))[0], state
    )


def _start(
    box: ModalSubdomain, scheme: Scheme, model: FrameModel, step: float, spin: ArrayLike, rate: float = 0.0
) -> FrameState:
    p = jnp.asarray(box.points.placed(np.zeros(3), np.eye(3)) - box.points.origin)
    k = model.stiffness.shape[0]
    state = FrameState(p, jnp.zeros(k), jnp.cross(jnp.asarray(spin), p), jnp.full(k, rate))
    return _flown(scheme, model, state, 0.0, step, 1)


def free_flight(_quick: bool) -> dict[str, float]:
    """Errors of a rotating free box over 20 revolutions.

    links : largest residual of the links, over the squared arm of the frame
    angular_momentum, energy : largest relative change since the first step
    attitude_order : order of convergence of the rotation of the frame with the step
    published_scheme_brake : `_brake`
    """
    box, scheme = _box(12), ProjectedDifference()
    model = box.compiled()
    spin = 0.02 * box.frequencies[0] * np.array([0.3, 0.5, 1.0]) / np.linalg.norm([0.3, 0.5, 1.0])
    step = TURN / float(np.linalg.norm(spin))
    state = _start(box, scheme, model, step, spin)
    L = angular_momentum(model, state, step)
    E = step_kinetic_energy(model, state, step) + strain_energy(model, state, step)
    links = momentum = energy = 0.0
    for _ in range(20):
        state = _flown(scheme, model, state, step, step, round(2 * np.pi / TURN))
        now = step_kinetic_energy(model, state, step) + strain_energy(model, state, step)
        open_ = jnp.abs(link_residual(state.p, model.squared_lengths)).max() / box.points.arm**2
        change = jnp.linalg.norm(angular_momentum(model, state, step) - L) / jnp.linalg.norm(L)
        links, momentum = max(links, float(open_)), max(momentum, float(change))
        energy = max(energy, abs(float(now / E - 1)))
    return {
        "links": links,
        "angular_momentum": momentum,
        "energy": energy,
        "attitude_order": _order(box, scheme),
        "published_scheme_brake": _brake(),
    }


def _order(box: ModalSubdomain, scheme: Scheme) -> float:
    model, spin, ends = box.compiled(), 0.1 * box.frequencies[0] * np.array([0.2, 0.6, 0.8]), []
    for n in (400, 800, 1600, 6400):
        step = 40.0 / n
        state = _flown(scheme, model, _start(box, scheme, model, step, spin), step, step, n - 1)
        ends.append(arms(state.p) / box.points.arm)
    errors = [float(jnp.linalg.norm(rotation_log(end @ ends[-1].T))) for end in ends[:-1]]
    return float(np.polyfit(np.log([4, 2, 1]), np.log(errors), 1)[0])


def _brake() -> float:
    """Relative loss of angular momentum of a rigid box in one revolution, over the theoretical 2 pi Omega h.

    The box moves by `PublishedScheme`, with angular velocity Omega and step h.
    """
    own = _box(12)
    box = ModalSubdomain(own.body, np.zeros((own.body.n, 0)), np.zeros(0))
    model, scheme, turn = box.compiled(), PublishedScheme(), TURN / 4
    state = _start(box, scheme, model, turn, np.array([0.0, 0.0, 1.0]))
    L = angular_momentum(model, state, turn)
    state = _flown(scheme, model, state, turn, turn, round(2 * np.pi / turn))
    lost = 1 - jnp.linalg.norm(angular_momentum(model, state, turn)) / jnp.linalg.norm(L)
    return float(lost) / (2 * np.pi * turn)


def step_limit(_quick: bool) -> dict[str, float]:
    """Step limit of a free box in motion, and the step limit for clamped modes.

    stable_at, unstable_at : largest stable and smallest unstable step tested, over the computed step limit
    ratio_to_27_clamped : true step limit for clamped modes over that of [Radioss] (27)
    """
    box, scheme = _box(12), ProjectedDifference()
    model = box.compiled()
    stays, grows = 0.0, np.inf
    for fraction in (0.96, 0.98, 1.02, 1.04):
        step = fraction * box.step_limit
        state = _start(box, scheme, model, step, np.zeros(3), 1e-6)
        largest = float(jnp.abs(_flown(scheme, model, state, step, step, 3000).y).max())
        if largest < 1e-4:
            stays = max(stays, fraction)
        else:
            grows = min(grows, fraction)
    mesh = box.body.model.mesh  # ty: ignore[missing-union-attribute] - the body has elements
    held = np.zeros((27, box.body.n))
    held[np.arange(27), (3 * mesh.node_sets["root"][:, None] + np.arange(3)).ravel()] = 1
    clamped = box.body.lowest_modes(12, held)
    sums = moments(mass_fields(box.body, box.points, clamped.vectors))
    K = np.diag(clamped.values)
    ratio = true_limit(sums, box.points, K) / local_limit(sums, box.points.arm, K)
    return {"stable_at": stays, "unstable_at": grows, "ratio_to_27_clamped": ratio}

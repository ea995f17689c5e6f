"""The default scheme of a modal sub-domain: [Radioss] corrected (docs/theory/explicit.md)."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.spinning_box import box_body, flown, modal_box, spinning

from supple.algebra import lowest_modes
from supple.algebra.rotation import rotation_log
from supple.errors import ModelError
from supple.methods.explicit.frame_model import FrameModel, link_residual, step_kinetic_energy
from supple.methods.explicit.frame_moments import arms, moments
from supple.methods.explicit.mass_fields import mass_fields
from supple.methods.explicit.modal_subdomain import ModalSubdomain, modal_subdomain
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.step_limit import damped_limit, local_limit, true_limit
from supple.reduction import CraigBampton, NormalModes
from supple_benchmarks.explicit.free_flight import angular_momentum, linear_momentum, strain_energy

SCHEME = ProjectedDifference()
TURN = 5.8e-3  # rad in a step


@pytest.mark.slow
def test_free_flight_over_twenty_turns_keeps_links_momentum_and_energy():
    box = modal_box()
    axis = jnp.array([0.3, 0.5, 1.0])
    spin = 0.02 * box.frequencies[0] * axis / jnp.linalg.norm(axis)
    step = TURN / float(jnp.linalg.norm(spin))
    assert step < box.step_limit
    model, state = spinning(box, SCHEME, step, spin, velocity=(0.01, 0.02, 0.0))
    L, P = angular_momentum(model, state, step), linear_momentum(model, state, step)
    E = step_kinetic_energy(model, state, step) + strain_energy(model, state, step)
    energies = []
    for _ in range(20):
        state = flown(SCHEME, model, state, step, round(2 * np.pi / TURN))
        energies.append(float(step_kinetic_energy(model, state, step) + strain_energy(model, state, step)))
        assert np.abs(link_residual(state.p, model.squared_lengths)).max() < 1e-14 * box.points.arm**2
    assert jnp.linalg.norm(angular_momentum(model, state, step) - L) < 1e-10 * jnp.linalg.norm(L)
    assert jnp.linalg.norm(linear_momentum(model, state, step) - P) < 1e-10 * jnp.linalg.norm(P)
    drift = np.abs(np.array(energies) / float(E) - 1)
    assert drift.max() < 2e-8
    assert drift[10:].max() < 2 * drift[:10].max()  # bounded, not growing


@pytest.mark.slow
def test_attitude_is_of_second_order_in_the_step():
    box = modal_box()
    spin = 0.1 * box.frequencies[0] * jnp.array([0.2, 0.6, 0.8])
    duration, ends = 40.0, []
    for n in (400, 800, 1600, 6400):
        model, state = spinning(box, SCHEME, duration / n, spin)
        ends.append(arms(flown(SCHEME, model, state, duration / n, n - 1).p) / box.points.arm)
    errors = [float(jnp.linalg.norm(rotation_log(end @ ends[-1].T))) for end in ends[:-1]]
    assert np.polyfit(np.log([4, 2, 1]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)


def _vibrated(box, model, step, n):
    rates = jnp.full(box.n_modes, 1e-6)
    model, state = spinning(box, SCHEME, step, jnp.zeros(3), model=model, rates=rates)
    return float(jnp.abs(flown(SCHEME, model, state, step, n).y).max())


@pytest.mark.slow
def test_the_step_limit_of_free_modes_is_that_of_the_modes():
    box = modal_box()
    assert box.step_limit == pytest.approx(2 / box.frequencies[-1], rel=1e-9)
    still = _vibrated(box, None, 0.98 * box.step_limit, 4000)
    assert still < 1e-4
    grown = _vibrated(box, None, 1.02 * box.step_limit, 400)
    assert not grown < 1.0


def _clamped():
    """Modes of the box held at its end, with the frame they would be used on."""
    body, box = box_body(), modal_box()
    held = np.zeros((27, body.n))
    freedoms = (3 * body.model.mesh.node_sets["root"][:, None] + np.arange(3)).ravel()
    held[np.arange(27), freedoms] = 1
    modes = lowest_modes(body.stiffness, body.mass, 12, constraint=held)
    return box, modes, moments(mass_fields(body, box.points, modes.vectors))


@pytest.mark.slow
def test_modes_clamped_at_an_end_have_a_shorter_limit_that_is_exact():
    box, modes, sums = _clamped()
    K = np.diag(modes.values)
    true, local = true_limit(sums, box.points, K), local_limit(sums, box.points.arm, K)
    assert true < 0.6 * local
    model = FrameModel(
        sums, jnp.asarray(K), jnp.asarray(box.points.squared_lengths), jnp.asarray(0.0), jnp.asarray(0.0)
    )
    assert _vibrated(box, model, 0.98 * true, 4000) < 1e-4
    assert not _vibrated(box, model, 1.02 * true, 400) < 1.0


def test_modes_with_rigid_motion_are_refused():
    _, modes, _ = _clamped()
    with pytest.raises(ModelError, match="rigid motion"):
        ModalSubdomain(box_body(), modes.vectors, np.sqrt(modes.values))


def test_any_basis_becomes_free_of_rigid_motion_and_can_be_cut():
    from supple.body import RigidInterface, flexible_body

    held = flexible_body("box", box_body().model, [RigidInterface("root", "root")])
    whole = modal_subdomain(held, CraigBampton(6))
    cut = modal_subdomain(held, CraigBampton(6), highest=whole.frequencies[-1] / 2)
    assert cut.step_limit > 1.99 * whole.step_limit
    assert abs(held.rigid_modes.T @ held.mass @ cut.vectors).max() < 1e-8
    with pytest.raises(ModelError, match="no mode"):
        modal_subdomain(held, NormalModes(3), highest=1e-3)


def test_stiffness_damping_shortens_the_step_as_stated():
    box = modal_box()
    beta = 0.05 * box.step_limit
    limit = damped_limit(box.step_limit, beta)
    model = box.compiled()._replace(stiffness_damping=jnp.asarray(beta))
    assert _vibrated(box, model, 0.98 * limit, 4000) < 1e-4
    assert not _vibrated(box, model, 1.02 * limit, 2000) < 1.0


def test_mass_damping_takes_no_step_away_and_lets_modes_die_out():
    box = modal_box()
    model = box.compiled()._replace(mass_damping=jnp.asarray(0.5))
    step = 0.98 * box.step_limit
    assert _vibrated(box, model, step, round(100 / step)) < 1e-14


def test_increments_solve_the_discrete_equation_of_motion():
    """B(q_n)^T M [x(q_n+1) - 2 x_n + x_n-1] + h^2 K y in all directions that keep the links."""
    box = modal_box()
    step = 0.5 * box.step_limit
    spin = jnp.array([0.02, 0.05, 0.01])
    model, before = spinning(box, SCHEME, step, spin, rates=jnp.linspace(-0.1, 0.1, 12))
    now = flown(SCHEME, model, before, step, 7)
    after = flown(SCHEME, model, now, step, 1)
    fields = mass_fields(box.body, box.points, box.vectors)
    W, Phi, M = jnp.asarray(fields.weights), jnp.asarray(fields.shapes), fields.mass

    @jax.jit
    def x(q):
        p, y = q[:12].reshape(4, 3), q[12:]
        return W @ p + (Phi @ y) @ arms(p).T

    def q(state):
        return jnp.concatenate([state.p.reshape(12), state.y])

    B = jax.jit(jax.jacobian(x))(q(now))
    old = jnp.concatenate([(now.p - step * now.vp).reshape(12), now.y - step * now.vy])
    change = M @ np.asarray(x(q(after)) - 2 * x(q(now)) + x(old))
    residual = np.einsum("fiq,fi->q", B, change)
    residual[12:] += step**2 * np.asarray(model.stiffness @ now.y)
    links = np.asarray(
        jax.jit(jax.jacobian(lambda p: link_residual(p.reshape(4, 3), model.squared_lengths)))(q(now)[:12])
    )
    outside = residual[:12] - links.T @ np.linalg.lstsq(links.T, residual[:12], rcond=None)[0]
    size = float(np.abs(M @ np.asarray(x(q(now)) - x(old))).sum())
    assert np.abs(outside).max() < 1e-13 * size
    assert np.abs(residual[12:]).max() < 1e-13 * size

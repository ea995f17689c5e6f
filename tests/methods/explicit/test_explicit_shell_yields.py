"""Shells that yield: plane stress at layers against closed forms, objectivity, balance, deletion."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import stepped
from scipy.spatial.transform import Rotation

from supple.errors import ConvergenceError, ModelError, ValidityError, ValidityWarning
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import Run, Solution, Statistics, Validity
from supple.machine import (
    Placed,
    System,
)
from supple.mesh import strip
from supple.methods.explicit import (
    ENERGIES,
    ExplicitEngine,
    J2Plasticity,
    LinearHardening,
    PowerHardening,
    explicit_shell,
)
from supple.methods.explicit.elements import ElementInstant
from supple.methods.explicit.materials.plane_stress import elastic_state, mises_of, plane_stress
from supple.methods.explicit.motions import NodalMotion
from supple.methods.explicit.shell_strain import shell_strain_watch
from supple.simulation import simulate, watched_run

METAL = Isotropic(1000.0, 0.3, 1.0)
THICKNESS, YIELD = 0.05, 1.0
PERFECT = J2Plasticity(METAL, LinearHardening(YIELD))
ANGLE = np.array([0.4, -1.1, 0.7])


def plate(law=PERFECT, cells=(4, 2), name="plate", **more):
    model = shell_model(strip(2.0, 0.5, *cells), HomogeneousSection(METAL, THICKNESS))
    return explicit_shell(model, name=name, law=law, **more)


@pytest.fixture(scope="module")
def force():
    """Forces of a block at positions and triads, reached from a state."""

    def of_block(block, x, triads, state):
        return block.force(ElementInstant(x, jnp.zeros_like(x), jnp.ones(()), triads), state)

    return jax.jit(of_block)


def built(body, rotation=(0.0, 0.0, 0.0)):
    """Its block, and positions and triads at the start."""
    made = ExplicitEngine(System([Placed(body, rotation=np.array(rotation))]), Run(1.0, 1.0)).built
    return made.model.blocks[0], made.start.x, made.start.turning.triads


def turned_by(rotation, triads):
    """Triads (3, 3, r) after one rotation of all."""
    return jnp.einsum("ij,jkr->ikr", Rotation.from_rotvec(rotation).as_matrix(), triads)


def turned(triads, angles):
    """Triads (3, 3, r) turned by vectors (3, r)."""
    size = np.linalg.norm(angles, axis=0)
    axis = angles / np.where(size > 0, size, 1.0)
    cross = np.cross(axis[:, None], np.asarray(triads), axis=0)
    again = np.cross(axis[:, None], cross, axis=0)
    return jnp.asarray(triads + np.sin(size) * cross + (1 - np.cos(size)) * again)


@pytest.mark.slow
@pytest.mark.parametrize(
    "hardening", [LinearHardening(1.0), LinearHardening(1.0, 50.0), PowerHardening(1.0, 2.0, 0.3)]
)
def test_what_yields_returns_to_the_yield_surface_along_its_normal(hardening):
    """The residuals of backward Euler: the surface, the flow rule, and the work of the stress on the flow."""
    law = J2Plasticity(METAL, hardening)
    strain = jnp.asarray(4e-3 * np.random.default_rng(1).standard_normal((3, 400)))
    stress, state, work = plane_stress(law, strain, elastic_state((400,)))
    yields = np.asarray(state.strain) > 0
    assert 100 < yields.sum() < 400
    mises, limit = mises_of(stress), hardening.yield_stress(state.strain)
    np.testing.assert_allclose(mises[yields], limit[yields], rtol=1e-12)
    assert (mises[~yields] <= limit[~yields]).all()
    np.testing.assert_allclose(stress, METAL.plane_stress @ (strain - state.tensor), atol=1e-12)
    xx, yy, xy = stress
    normal = jnp.stack([xx - yy / 2, yy - xx / 2, 3 * xy]) / jnp.where(mises > 0, mises, 1.0)
    np.testing.assert_allclose(state.tensor, state.strain * normal, atol=1e-15)
    np.testing.assert_allclose(work, (stress * state.tensor).sum(axis=0), atol=1e-15)


@pytest.mark.slow
def test_tension_beyond_yield_follows_linear_hardening(force):
    """Stretched with free contraction, sigma = sigma_y + E H / (E + H) (eps - sigma_y / E).

    By so little that the square of the strain, which turns the frames of the triangles, does not count.
    """
    limit, modulus, stretch = 1e-5, 100.0, 5e-8
    law = J2Plasticity(METAL, LinearHardening(limit, modulus))
    block, x, triads = built(plate(law))
    E, tangent = METAL.youngs_modulus, METAL.youngs_modulus * modulus / (METAL.youngs_modulus + modulus)
    expected = limit + tangent * (stretch - limit / E)
    plastic = (expected - limit) / modulus
    # Contraction: elastic by nu, plastic by half.
    across = -METAL.poissons_ratio * expected / E - 0.5 * plastic
    moved = x * (1 + jnp.array([stretch, across, 0.0]))[:, None]
    out = force(block, moved, triads, block.start())
    right = np.asarray(x[0]) > 2.0 - 1e-9
    pull = -np.asarray(out.force)
    assert pull[0, right].sum() == pytest.approx(expected * 0.5 * THICKNESS, rel=1e-6)
    assert np.abs(pull[1]).max() < 1e-6 * pull[0, right].sum()
    np.testing.assert_allclose(out.state.material.strain, plastic, rtol=1e-6)
    _, mises = block.recorded(moved, triads, out.state)
    np.testing.assert_allclose(mises, expected, rtol=1e-6)


@pytest.mark.slow
def test_bending_beyond_yield_has_the_moment_of_the_plastic_hinge(force):
    """M / M_y = 3/2 - 1/2 (kappa_y / kappa)^2 of a rectangular section that does not harden.

    With Poisson's ratio of nearly a half, as plastic flow has it, a plate that also curves across by that
    much has stress along x alone. The moment is the work on the nodes over the curvature: of unit width.
    """
    nu, limit, ratio = 0.4999, 1e-5, 2.0
    metal = Isotropic(1000.0, nu, 1.0)
    law = J2Plasticity(metal, LinearHardening(limit))
    first = 2 * limit / metal.youngs_modulus / THICKNESS
    model = shell_model(strip(2.0, 0.5, 4, 2), HomogeneousSection(metal, THICKNESS))
    errors = []
    for layers in (5, 40):
        block, x, triads = built(explicit_shell(model, law=law, layers=layers))
        # Per unit of curvature: deflection and the rotations (w,y, -w,x).
        zero = np.zeros_like(x[0])
        lift = np.stack([zero, zero, -0.5 * x[0] ** 2 + 0.5 * nu * x[1] ** 2])
        turn = np.stack([nu * x[1], x[0], zero])
        curvature = ratio * first
        out = force(block, x + curvature * lift, turned(triads, curvature * turn), block.start())
        moment = -float((out.force * lift).sum() + (out.moment * turn).sum()) / (2.0 * 0.5)
        exact = (1.5 - 0.5 / ratio**2) * limit * THICKNESS**2 / 6
        errors.append(abs(moment / exact - 1))
        # The rule through the thickness, of the exact stress: all that may differ.
        z, weights = (np.asarray(each) for each in (block.layers.heights, block.layers.weights))
        stress = np.clip(metal.youngs_modulus * curvature * z, -limit, limit)
        assert moment == pytest.approx(weights @ (z * stress), rel=1e-3)
    assert errors[0] < 0.04
    assert errors[1] < errors[0] / 20


@pytest.mark.slow
def test_below_yield_a_layered_shell_is_the_elastic_one(force):
    block, x, triads = built(plate())
    d = 1e-6 * np.random.default_rng(3).standard_normal((6, x.shape[1]))
    at, turns = x + d[:3], turned(triads, d[3:])
    out = force(block, at, turns, block.start())
    elastic = force(replace(block, law=None), at, turns, block.start())
    np.testing.assert_allclose(out.force, elastic.force, atol=1e-11 * np.abs(elastic.force).max())
    np.testing.assert_allclose(out.moment, elastic.moment, atol=1e-11 * np.abs(elastic.moment).max())
    assert float(out.plastic) == 0


@pytest.mark.slow
def test_a_plate_that_turns_while_it_yields_has_the_same_stress(force):
    """Strained by halves, the second in another place: the same plastic strain, forces turned."""
    (block, x, triads), (_, far, _) = built(plate()), built(plate(), ANGLE)
    about = turned_by(ANGLE, triads)
    R = np.asarray(about)[:, :, 0]
    d = 2e-3 * np.random.default_rng(4).standard_normal((6, x.shape[1]))
    half = force(block, x + 0.5 * d[:3], turned(triads, 0.5 * d[3:]), block.start())
    plain = force(block, x + d[:3], turned(triads, d[3:]), half.state)
    spun = force(block, far + R @ d[:3], turned(about, R @ d[3:]), half.state)
    assert float(plain.state.material.strain.max()) > 1e-3
    scale = np.abs(np.asarray(plain.force)).max()
    np.testing.assert_allclose(spun.state.material.strain, plain.state.material.strain, atol=1e-12)
    np.testing.assert_allclose(spun.force, R @ np.asarray(plain.force), atol=1e-11 * scale)
    np.testing.assert_allclose(spun.moment, R @ np.asarray(plain.moment), atol=1e-11 * scale)


@pytest.mark.slow
def test_a_spinning_plate_that_yields_and_breaks_keeps_momenta_and_balance():
    """Its own spin tears it: elements go at their plastic strain, and nothing is lost to it."""
    limit = 0.01
    law = J2Plasticity(METAL, LinearHardening(YIELD, 50.0))
    part = Placed(plate(law, deletion=limit), angular_velocity=np.array([0.0, 0.0, 2.0]))
    span = Run(0.4, 0.1)
    engine = ExplicitEngine(System([part]), stepped(span, safety=0.5))
    start = engine.start(0.0)
    leg = engine.march(start, span.times)
    motion, e = engine.solution(leg).bodies["plate"], engine.solution(leg).series[ENERGIES]
    momenta = []
    for state in (start, leg.last):
        x, v, m = (np.asarray(a) for a in (state.x, state.v, engine.built.model.mass))
        J = np.asarray(engine.built.model.spins.inertia)
        before = x - float(state.before) * v
        spin = (J * np.asarray(state.turning.rates)).sum(axis=1)
        linear = (m * v).sum(axis=1)
        momenta.append(np.concatenate([linear, np.cross(before.T, (m * v).T).sum(axis=0) + spin]))
    assert leg.stopped is None
    assert np.abs(momenta[1] - momenta[0]).max() < 1e-11 * np.abs(momenta[0]).max()
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 1e-12
    assert e[-1, 2] > 1e-3 * total[0]
    gone = motion.alive[-1] == 0
    assert 0 < gone.sum() < len(gone)
    np.testing.assert_array_equal(motion.plastic_strain[-1] >= limit, gone)
    assert (motion.von_mises[-1][gone] == 0).all()


def test_what_no_shell_can_yield_by_is_refused():
    other = J2Plasticity(Isotropic(900.0, 0.3, 1.0), LinearHardening(1.0))
    with pytest.raises(ModelError, match="other elastic constants"):
        plate(other)
    with pytest.raises(ModelError, match="at least 2"):
        plate(layers=1)
    with pytest.raises(ModelError, match="deletion"):
        plate(deletion=0.0)


def test_the_step_shortens_with_the_smallest_stretch_of_a_triangle():
    """A plate pressed to 0.7 of its length, sheared and rotated: the singular value of the deformation."""
    body = plate()
    engine = ExplicitEngine(System([body]), Run(1.0, 1.0))
    arrays, start = engine.built.model.blocks[0], engine.built.start
    alive = jnp.ones(16)
    rest = float(arrays.longest_step(start.x, start.v, alive, 0.0))
    assert rest == pytest.approx(body.step_limit, rel=1e-14)
    changed = np.array([[0.7, 0.3, 0], [0, 1.1, 0], [0, 0, 1.0]])
    x = jnp.asarray(Rotation.from_rotvec(ANGLE).as_matrix() @ changed) @ start.x
    smallest = np.linalg.svd(changed[:2, :2], compute_uv=False)[-1]
    assert np.asarray(arrays.stretch(x)) == pytest.approx(smallest, rel=1e-12)
    found = float(arrays.longest_step(x, start.v, alive, 0.0))
    assert found == pytest.approx(smallest * rest, rel=1e-12)
    flat = jnp.asarray(np.diag([0.0, 1.0, 1.0])) @ start.x
    assert float(arrays.longest_step(flat, start.v, alive, 0.0)) == pytest.approx(0.05 * rest)


def strained(largest):
    """A leg of the plate, the second of whose cells strains at t = 1."""
    strain = np.zeros((2, 16))
    strain[1, 1] = largest
    none = np.zeros((2, 0, 3))
    motion = NodalMotion(none, none, none, strain, 1 + 0 * strain, 0 * strain)
    return Solution(np.array([0.0, 1.0]), {"plate": motion}, {}, Statistics())


def test_a_strain_that_is_not_small_is_warned_of(recwarn):
    system = System([plate(), plate(None, name="elastic")])
    watch = shell_strain_watch(system, Validity())
    watch.report(watch.observe({}, strained(0.19)))
    assert not recwarn.list
    told = r"'plate' reaches a plastic strain of 0.21 in cell 1 \(t = 1\).*wrong by more than 10 %"
    with pytest.warns(ValidityWarning, match=told):
        watch.report(watch.observe({}, strained(0.21)))
    with pytest.raises(ValidityError, match=told):
        shell_strain_watch(system, Validity(strict=True)).observe({}, strained(0.21))


def test_a_run_that_ends_early_warns_of_the_limits_it_exceeded(monkeypatch):
    """They may be the cause: a shell of large strain ends with a collapsed cell and spurious energy."""

    def ended(*_, record, **__):
        record(strained(1.3))
        raise ConvergenceError("the internal energy is negative")

    monkeypatch.setattr(watched_run, "march_through", ended)
    with (
        pytest.warns(ValidityWarning, match="reaches a plastic strain of 1.3"),
        pytest.raises(ConvergenceError),
    ):
        simulate(System([plate()]), Run(1.0, 1.0))

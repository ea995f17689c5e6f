"""Explicit shells: gradient of the energy, step limit, free flight, a cantilever under a sudden load."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import stepped
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from supple.body import LinearRayleighDamping
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import Run, run
from supple.machine import (
    At,
    DeadForce,
    FollowerPressure,
    Placed,
    Support,
    System,
)
from supple.mesh import CellType, strip
from supple.methods.explicit import (
    ENERGIES,
    ExplicitEngine,
    explicit_shell,
)
from supple.methods.explicit.elements import ElementInstant

PLATE = Isotropic(1000.0, 0.3, 1.0)
THICKNESS = 0.05


def plate(length=2.0, width=0.5, cells=(8, 2), **more):
    section = HomogeneousSection(PLATE, THICKNESS)
    return explicit_shell(shell_model(strip(length, width, *cells), section), name="plate", **more)


def marched(system, span, n=10, **options):
    engine = ExplicitEngine(system, stepped(Run(span, span / n), **options))
    return engine, run(engine, Run(span, span / n).times)


def test_a_pressure_pushes_a_plate_along_its_deformed_normal():
    """Uniform pressure gives a free plate the acceleration p / (rho t) against its normal.

    The plate rotates meanwhile by a quarter of a revolution; its rotation strains it by 1e-3.
    """
    body, rate, pressure = plate(cells=(4, 2)), 0.5 * np.pi, 0.01
    faces = body.mesh.cells[CellType.TRIANGLE3]
    turned = Placed(body, rotation=(0, 0.5 * np.pi, 0), angular_velocity=(0, rate, 0))
    load = FollowerPressure(body="plate", faces=faces, pressure=pressure)
    machine = System([turned.with_centre_velocity((0, 0, 0))], loads=[load])
    _, solution = marched(machine, 1.0)
    phi = rate * solution.times
    acceleration = -pressure / (PLATE.density * THICKNESS)
    # The normal is (cos phi, 0, -sin phi).
    moved = acceleration / rate**2 * np.column_stack([1 - np.cos(phi), 0 * phi, np.sin(phi) - phi])
    at = solution.bodies["plate"].nodes
    assert at.mean(axis=1) - at[0].mean(axis=0) == pytest.approx(moved, abs=3e-3 * abs(moved).max())


def force(block, x, triads):
    """Force and moment of a block at positions and triads."""
    return block.force(ElementInstant(x, jnp.zeros_like(x), jnp.ones(()), triads), block.start())


@pytest.mark.slow
def test_small_deformation_has_the_forces_of_the_models_stiffness():
    body = plate()
    engine = ExplicitEngine(System([body]), Run(1.0, 1.0))
    (block,) = engine.built.model.blocks
    start = engine.built.start
    rng = np.random.default_rng(3)
    d = 1e-6 * rng.standard_normal((len(body.nodes), 6))
    x = start.x + d[:, :3].T
    turn = jnp.cross(jnp.asarray(d[:, 3:].T)[:, None], start.turning.triads, axis=0)
    out = force(block, x, start.turning.triads + turn)
    found = np.column_stack([np.asarray(out.force).T, np.asarray(out.moment).T]).ravel()
    expected = -body.model.stiffness @ d.ravel()
    assert np.abs(found - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.slow
def test_a_turned_plate_has_no_forces_and_a_turned_deformed_one_turned_forces():
    body = plate()
    angle = np.array([0.4, -1.1, 0.7])
    flat, turned = (
        ExplicitEngine(System([Placed(body, rotation=r)]), Run(1.0, 1.0)).built for r in (np.zeros(3), angle)
    )
    (block,) = flat.model.blocks
    R, triads = Rotation.from_rotvec(angle).as_matrix(), np.asarray(flat.start.turning.triads)
    spun_triads = jnp.einsum("ij,jkr->ikr", R, triads)
    rest = force(block, turned.start.x, spun_triads)
    moved = 0.01 * np.random.default_rng(4).standard_normal(flat.start.x.shape)
    plain = force(block, flat.start.x + moved, triads)
    spun = force(block, turned.start.x + R @ moved, spun_triads)
    scale = np.abs(np.asarray(plain.force)).max()
    assert np.abs(np.asarray(rest.force)).max() < 1e-11 * scale
    np.testing.assert_allclose(spun.force, R @ np.asarray(plain.force), atol=1e-11 * scale)
    np.testing.assert_allclose(spun.moment, R @ np.asarray(plain.moment), atol=1e-11 * scale)


def test_the_step_limit_is_below_the_true_one_and_near_it():
    body = plate()
    diagonal = np.column_stack([body.masses] * 3 + [body.inertias] * 3).ravel()
    K = body.model.stiffness.toarray()
    true = 2 / np.sqrt(np.linalg.eigvalsh(K / np.sqrt(diagonal[:, None] * diagonal))[-1])
    assert 0.5 * true < body.step_limit <= true
    with pytest.raises(ModelError, match="above the stability limit"):
        ExplicitEngine(System([body]), stepped(Run(1.0, 1.0), step=1.01 * body.step_limit))


def test_a_plate_that_spins_and_bends_keeps_both_momenta_and_its_balance():
    """Twisted and bent at the start by its own rates; angular momentum with that of the triads."""
    part = Placed(plate(), velocity=(0.3, 0.1, 0), angular_velocity=(1.0, 0.5, 2.0))
    engine, solution = marched(System([part]), 2.0)
    states = []
    state = engine.start(0.0)
    for _ in range(2):
        state = engine.march(state, np.array([float(state.time) + 1.0])).last
        x, v, m = (np.asarray(a) for a in (state.x, state.v, engine.built.model.mass))
        J = np.asarray(engine.built.model.spins.inertia)
        before = x - float(state.before) * v
        spin = (J * np.asarray(state.turning.rates)).sum(axis=1)
        states.append(np.concatenate([(m * v).sum(axis=1), np.cross(before.T, (m * v).T).sum(axis=0) + spin]))
    assert np.abs(states[1] - states[0]).max() < 1e-11 * np.abs(states[0]).max()
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert e[:, 1].max() > 1e-6 * total[0]
    assert np.abs(total / total[0] - 1).max() < 1e-12
    R = np.asarray(state.turning.triads)
    np.testing.assert_allclose(
        np.einsum("ian,ibn->nab", R, R), np.broadcast_to(np.eye(3), (R.shape[2], 3, 3)), atol=1e-12
    )


def swing(cells):
    """First bending of a cantilever under a sudden load, by the march and by the consistent linear model.

    Each of its modes answers a step load in closed form: q (1 - cos omega t).
    """
    body = plate(length=1.0, cells=cells)
    force = 1e-5
    held = Support(At("plate", "root"), (0, 1, 2, 3, 4, 5))
    push = DeadForce(at="plate.tip", force=(0.0, 0.0, force))
    _, solution = marched(System([body], supports=[held], loads=[push]), 4.5, n=30)
    sets = body.model.mesh.node_sets
    free = np.setdiff1d(np.arange(body.model.n_dofs), (6 * sets["root"][:, None] + np.arange(6)).ravel())
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (body.model.stiffness, body.model.mass))
    values, modes = eigh(K, M)
    shapes = np.zeros((body.model.n_dofs, len(values)))
    shapes[free] = modes
    bending = shapes[2::6]  # of all modes, along the load
    first = body.masses * bending[:, 0]
    gains = force * bending[sets["tip"]].mean(axis=0) / values
    assert solution.times[-1] > 2 * np.pi / np.sqrt(values[0])
    expected = (1 - np.cos(np.sqrt(values) * solution.times[:, None])) @ (gains * (first @ bending))
    return solution.bodies["plate"].nodes[:, :, 2] @ first, expected, solution.bodies["plate"]


@pytest.mark.slow
def test_a_cantilever_under_a_sudden_load_swings_as_the_full_model():
    """What lumping changes over a period goes with the square of the element."""
    errors = []
    for cells in ((6, 2), (12, 4)):
        found, expected, motion = swing(cells)
        errors.append(np.abs(found - expected).max() / np.abs(expected).max())
        root, tip = np.array_split(motion.von_mises[-1], 2)
        assert root.max() > tip.max() > 0
    assert errors[1] < 0.05
    assert errors[0] > 3 * errors[1]


def test_what_is_no_explicit_shell_is_refused():
    with pytest.raises(ModelError, match="beta = 0"):
        plate(damping=LinearRayleighDamping(0.0, 1e-3))
    with pytest.raises(ModelError, match="explicit shell 'plate': its damping is relative to the interface"):
        plate(damping=LinearRayleighDamping(1.0, 0.0, held="root"))
    with pytest.raises(ModelError, match="rotations, of shells alone"):
        marched(System([plate()], supports=[Support(At("plate", "root"), (6,))]), 1.0)


def test_mass_damping_takes_out_of_turning_what_it_says():
    """A plate that only turns, lightly damped: energy plus what the damping took is constant."""
    part = Placed(plate(damping=LinearRayleighDamping(0.5, 0.0)), angular_velocity=(0, 0, 1.0))
    _, solution = marched(System([part]), 1.0)
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert e[-1, 0] == pytest.approx(e[0, 0] * np.exp(-1.0), rel=1e-2)
    assert np.abs(total / total[0] - 1).max() < 1e-12
    assert jax.tree.leaves(solution.bodies["plate"].arrays())

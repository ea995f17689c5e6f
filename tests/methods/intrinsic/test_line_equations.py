"""The factorised equations: those of dense tensors, their power, damping, and the places they lead to."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.body import LinearRayleighDamping, ModalDamping, RayleighDamping
from supple.errors import ModelError
from supple.methods.intrinsic import (
    BALL,
    CLAMPED,
    FREE,
    condensed_line,
    intrinsic_body,
    intrinsic_modes,
    line_equations,
    released,
    strain_integration,
)
from supple.methods.intrinsic.line_model import line_model
from supple.methods.intrinsic.stable_step import linear_eigenvalues
from supple.methods.intrinsic.strain_integration import rotation_of
from supple_benchmarks.intrinsic import dense_couplings as dense

SECTION = {"EA": 1e5, "EI": (10.0, 4.0), "GJ": 8.0, "mass_per_length": 1.3, "radius": 0.02}
# Compiled as a whole: one by one, their operations are hundreds of programs.
line_rates = jax.jit(line_equations.line_rates)
station_places = jax.jit(strain_integration.station_places)
dense_rates = jax.jit(lambda model, q1, q2: dense.dense_rates(model, dense.dense_couplings(model), q1, q2))
PARENTS = [-1, 0, 1, 2, 3, 2, 5, 6]
M = 20


def tree_line():
    rng = np.random.default_rng(0)
    points = np.zeros((8, 3))
    for station in range(1, 8):
        points[station] = points[PARENTS[station]] + rng.standard_normal(3)
    return beam_line(points, parents=PARENTS, **SECTION)


def shared_mass_line():
    line = beam_line(straight(2.0, 6), **SECTION)
    mass = line.mass.copy()
    mass[6:9, 12:15] = mass[12:15, 6:9] = 0.02 * np.eye(3)
    return condensed_line("shared", line.tree.points, line.stiffness, mass)


LINES = [lambda: beam_line(straight(2.0, 6), **SECTION), tree_line, shared_mass_line]


def amplitudes(modes, seed=1):
    rng = np.random.default_rng(seed)
    return rng.standard_normal(modes.n_modes), rng.standard_normal(modes.n_elastic)


@pytest.mark.parametrize(
    ("make", "support"),
    [
        pytest.param(make, support, marks=() if i == k else pytest.mark.slow)
        for i, make in enumerate(LINES)
        for k, support in enumerate([CLAMPED, BALL, FREE])
    ],
)
def test_factors_and_tensors_give_the_same_rates_for_any_truncation(make, support):
    modes = intrinsic_modes(make(), support, M)
    model, (q1, q2) = line_model(modes), amplitudes(modes)
    exact = dense_rates(model, q1, q2)
    for a, b in zip(line_rates(model, q1, q2), exact, strict=True):
        assert a == pytest.approx(np.asarray(b), abs=1e-13 * float(np.abs(b).max()))


@pytest.mark.parametrize("make", LINES)
def test_couplings_have_no_power(make):
    modes = intrinsic_modes(make(), FREE, M)
    model, (q1, q2) = line_model(modes), amplitudes(modes)
    d1, d2 = line_rates(model, q1, q2)
    assert abs(q1 @ d1 + q2 @ d2) < 1e-14 * np.linalg.norm(q1) * np.linalg.norm(d1)


def test_viscous_strains_take_power_whatever_the_state():
    modes = intrinsic_modes(tree_line(), FREE, M)
    q1, q2 = amplitudes(modes)
    d1, d2 = line_rates(line_model(modes, RayleighDamping(0.0, 0.01)), q1, q2)
    assert q1 @ d1 + q2 @ d2 == pytest.approx(float(-0.01 * d2 @ d2), rel=1e-12)


def test_modal_damping_takes_power_of_strain_rates():
    """2 zeta / w of each mode: about rest that is 2 zeta w of its velocity."""
    modes = intrinsic_modes(tree_line(), FREE, M)
    q1, q2 = amplitudes(modes)
    model = line_model(modes, ModalDamping([0.02, 0.05]))
    d1, d2 = line_rates(model, q1, q2)
    ratios = np.append(0.02, np.full(modes.n_elastic - 1, 0.05))
    expected = -(2 * ratios / modes.omega[6:]) @ d2**2
    assert q1 @ d1 + q2 @ d2 == pytest.approx(float(expected), rel=1e-11)
    slow = 1e-6 * q1
    d1, _ = line_rates(model, slow, 0 * q2)
    linear = -2 * ratios * modes.omega[6:] * slow[6:]
    assert d1[6:] == pytest.approx(np.asarray(linear), abs=1e-3 * np.abs(linear).max())
    with pytest.raises(
        ModelError, match="LinearRayleighDamping belongs to the stiffness in a floating frame"
    ):
        line_model(modes, LinearRayleighDamping(0.0, 0.01))
    with pytest.raises(ModelError, match="is relative to the interface 'root', which needs a body in a"):
        line_model(modes, ModalDamping(0.02, held="root"))


def test_modes_of_a_line_beyond_those_that_are_damped_are_not():
    modes = intrinsic_modes(tree_line(), FREE, M)
    q1, q2 = amplitudes(modes)
    d1, d2 = line_rates(line_model(modes, ModalDamping(0.02, n_modes=3)), q1, q2)
    expected = -(0.04 / modes.omega[6:9]) @ d2[:3] ** 2
    assert q1 @ d1 + q2 @ d2 == pytest.approx(float(expected), rel=1e-11)


@pytest.mark.parametrize("damping", [ModalDamping([0.02, 0.05]), RayleighDamping(3.0, 0.01)])
def test_damping_of_a_released_body_belongs_to_the_modes_on_its_support(damping):
    """Equal velocities lose equal power; rigid motion loses none."""
    body = intrinsic_body(LINES[0](), CLAMPED, damping=damping)
    free = released(body)
    held = np.random.default_rng(2).standard_normal(body.modes.n_modes)
    fields = [each.modes.velocities.reshape(6 * body.line.n, -1) for each in (body, free)]
    moving = np.linalg.lstsq(fields[1], fields[0] @ held, rcond=None)[0]
    powers = []
    for model, q1 in ((body.model, held), (free.model, moving)):
        d1, _ = line_rates(model, q1, np.zeros(body.n_coordinates))
        powers.append(float(q1 @ d1))
    assert powers[1] == pytest.approx(powers[0], rel=1e-9)
    # A diagonal matrix of retardation times has the eigenvalues of its diagonal.
    omega, decay = body.modes.omega, np.asarray(body.model.decay)
    own = linear_eigenvalues(omega, decay, body.model.retardation)
    as_matrix = linear_eigenvalues(omega, np.diag(decay), np.diag(body.model.retardation))
    assert np.sort_complex(as_matrix) == pytest.approx(np.sort_complex(own), rel=1e-9)
    rigid = np.eye(free.modes.n_modes)[:6].T
    assert line_equations.decay_rates(free.model, rigid) == pytest.approx(0.0, abs=1e-12)


def test_a_rigid_turn_of_a_bent_line_changes_no_strain_to_the_order_of_the_grid():
    """x_1 of a rigid turn of the deformed line gives no strain rate: O(h^2), as the paper's momentum."""
    defects = []
    for n in (8, 16):
        modes = intrinsic_modes(beam_line(straight(2.0, n), **SECTION), FREE)
        model = line_model(modes)
        q2 = np.zeros(modes.n_elastic)
        q2[:3] = [3.0, -2.0, 1.0]
        places = station_places(model, q2, np.eye(3), np.zeros(3))
        w = np.array([0.4, 1.0, -0.3])
        v = np.einsum("nji,nj->ni", places.rotations, np.cross(w, places.positions))
        turning = np.hstack([v, np.einsum("nji,j->ni", places.rotations, w)])
        q1 = modes.momenta.reshape(-1, modes.n_modes).T @ turning.ravel()
        defects.append(np.linalg.norm(line_rates(model, q1, q2)[1]) / np.linalg.norm(modes.omega[6:9] * 3))
    assert defects[0] < 0.05
    assert np.log2(defects[0] / defects[1]) > 1.7


def test_places_at_rest_are_the_points_on_chains_and_trees():
    for make in LINES[:2]:
        line = make()
        model = line_model(intrinsic_modes(line, FREE, M))
        places = station_places(model, np.zeros(M - 6), np.eye(3), line.tree.points[0])
        assert places.positions == pytest.approx(line.tree.points, abs=1e-14)


def test_constant_curvature_bends_a_line_into_a_circle():
    line = beam_line(straight(2.0, 12), **SECTION)
    modes = intrinsic_modes(line, CLAMPED)
    strains = np.zeros((12, 6))
    strains[:, 4] = -np.pi / 2.0  # half a circle over its length
    q2 = np.linalg.lstsq(modes.strains.reshape(72, -1), strains.ravel(), rcond=None)[0]
    places = station_places(line_model(modes), q2, np.eye(3), np.zeros(3))
    assert places.positions[-1] == pytest.approx([0, 0, 4 / np.pi], abs=1e-12)
    assert places.rotations[-1] == pytest.approx(np.diag([-1.0, 1.0, -1.0]), abs=1e-12)


def test_quaternions_of_any_length_are_rotations():
    rotation = rotation_of(np.array([0.3, -1.0, 2.0, 0.7]))
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_rates_can_be_differentiated_by_the_data_of_the_modes():
    modes = intrinsic_modes(tree_line(), CLAMPED, 8)
    model, (q1, q2) = line_model(modes), amplitudes(modes)

    @jax.jit
    def power(factor):
        return line_rates(replace(model, omega=factor * model.omega), q1, q2)[0] @ q1

    slope = jax.grad(power)(1.0)
    assert slope == pytest.approx(float(power(1 + 1e-6) - power(1 - 1e-6)) / 2e-6, rel=1e-7)

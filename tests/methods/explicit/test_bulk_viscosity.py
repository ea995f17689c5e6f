"""Bulk viscosity: its pressure in closed form, rotations, fronts without overshoot, its step, its work."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.explicit_bars import explicit_bar
from jax import lax

from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import Run
from supple.machine import (
    DeadForce,
    Placed,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    BulkViscosity,
    ExplicitEngine,
    explicit_subdomain,
)
from supple.methods.explicit.elements.bulk_viscosity import bulk_pressure
from supple.methods.explicit.march.interval import nodes_limit
from supple.methods.explicit.march.march_step import march_step
from supple.simulation import simulate

ROD = Isotropic(100.0, 0.0, 1.0)  # no lateral strain: waves of a bar are those of a string, c = 10
C = 10.0
NONE, USUAL = BulkViscosity(0.0, 0.0), BulkViscosity()


def cube(viscosity, size=0.1, material=ROD):
    model = solid_model(block(size, size, size, 1, 1, 1, CellType.HEXA8), material)
    return explicit_subdomain(model, name="cube", hourglass=0.0, bulk_viscosity=viscosity)


def squeezed(rate, h, b1, b2, size=0.1):
    """q of a cube whose side shortens at the rate (or lengthens)."""
    (own,) = cube(BulkViscosity(b1, b2), size).bulk_arrays
    q, work = bulk_pressure(own, jnp.ones((1, 1)), jnp.full((1, 1), 1 - h * rate), jnp.asarray(h))
    return float(q[0, 0]), float(work[0, 0])


def test_its_pressure_is_that_of_von_neumann_and_landshoff():
    """Q = rho c L (b1 |D| + b2^2 L / c D^2) of a cube of side L, the quadratic part in compression alone."""
    size, b1, b2, h = 0.1, 0.05, 1.3, 1e-6
    for rate in (-40.0, -4.0, 4.0):
        quadratic = size / C * b2**2 * rate**2 if rate < 0 else 0.0
        expected = ROD.density * C * size * (-b1 * rate + quadratic)
        q, work = squeezed(rate, h, b1, b2, size)
        assert q == pytest.approx(expected, rel=1e-4)
        assert work == pytest.approx(-expected * h * rate, rel=1e-3)
        assert work > 0


def front(viscosity, kind=CellType.HEXA8, cells=60, stress=0.1):
    """Of the front of a step force: stress, velocity and place over d'Alembert's; balance; lost energy."""
    model = solid_model(block(0.1 * cells, 0.1, 0.1, cells, 1, 1, kind), ROD)
    rod = explicit_subdomain(model, name="rod", bulk_viscosity=viscosity)
    push = DeadForce(at="rod.root", force=(stress * 0.01, 0.0, 0.0))
    time = 0.6 * 0.1 * cells / C
    solution = simulate(System([rod], loads=[push]), Run(time, time / 4))
    motion, e = solution.bodies["rod"], solution.series["energies"]
    middle = motion.von_mises[-1][cells // 6 : cells // 4].mean()
    x, v = rod.nodes[:, 0], motion.velocities[-1, :, 0]
    order, half = np.argsort(-x), 0.5 * stress / C
    late = time - 0.5 * solution.series["steps"][-1, 0]
    place = np.interp(half, v[order], x[order]) / (C * late)
    balance = np.abs(e[:, :7].sum(axis=1) - e[:, 7]).max() / np.abs(e).max()
    return (
        motion.von_mises[-1].max() / stress,
        v.max() * C / stress,
        middle / stress,
        place,
        balance,
        e[-1, 5],
    )


@pytest.mark.slow
def test_a_front_in_a_bar_is_that_of_d_alembert():
    """Stress sigma and velocity sigma / (rho c) behind it, where c t is; without viscosity a quarter more."""
    stress, velocity, _, _, balance, lost = front(NONE)
    assert min(stress, velocity) > 1.2
    assert balance < 1e-12
    assert lost == 0.0
    stress, velocity, middle, place, balance, lost = front(USUAL)
    assert max(stress, velocity) < 1.04
    assert middle == pytest.approx(1.0, abs=5e-3)
    assert place == pytest.approx(1.0, abs=0.01)
    assert balance < 1e-12
    assert lost > 0.0


def marched(engine, h, n):
    own = engine.built
    state = own.start._replace(v=1e-6 * jax.random.normal(jax.random.key(0), own.start.v.shape))
    go = jax.jit(lambda s: lax.fori_loop(0, n, lambda _, s: march_step(own.model, own.methods, s, h, 1), s))
    return float(jnp.abs(go(state).v).max()) / 1e-6


@pytest.mark.slow
def test_the_step_accounts_for_it():
    """Of a cube without lateral strain: xi = 3 b_1 of its breathing, dt = L / c (sqrt(1 + xi^2) - xi)."""
    for b1 in (0.0, 0.06, 0.2):
        engine = ExplicitEngine(System([cube(BulkViscosity(b1, 0.0))]), Run(1.0, 1.0))
        limit = float(nodes_limit(engine.built.model, engine.built.start, 1.0))
        xi = 3 * b1
        assert limit == pytest.approx(0.1 / C * (np.sqrt(1 + xi**2) - xi), rel=1e-9)
    assert marched(engine, 0.999 * limit, 2000) < 10.0
    # Beyond, the viscosity is what the step bears.
    assert marched(engine, 0.5 * (limit + 0.0099), 2000) < 10.0


def test_a_compression_shortens_the_step():
    steps = []
    for rate in (0.0, -10.0, 10.0):
        engine = ExplicitEngine(System([cube(BulkViscosity(0.0, 1.2))]), Run(1.0, 1.0))
        start = engine.built.start
        steps.append(float(nodes_limit(engine.built.model, start._replace(v=rate * start.x), 1.0)))
    xi = 3 * 1.2**2 * 0.1 / C * 30.0  # of three directions
    assert steps[1] / steps[0] == pytest.approx(np.sqrt(1 + xi**2) - xi, rel=1e-3)
    assert steps[2] == steps[0]


def test_a_sudden_force_is_followed_step_by_step():
    """In the first step no force but the viscous one has done work; the momentum is F (t - h/2)."""
    bar = explicit_bar(CellType.HEXA8)
    h, force = 0.4 * bar.step_limit, 0.1
    push = DeadForce(at="bar.tip", force=(force, 0.0, 0.0))
    solution = simulate(System([bar], loads=[push]), Run(5 * h, h))
    assert solution.statistics.steps == 5
    momentum = np.einsum("n,tn->t", bar.masses, solution.bodies["bar"].velocities[1:, :, 0])
    assert momentum == pytest.approx(force * (solution.times[1:] - h / 2), rel=1e-9)


@pytest.mark.slow
def test_it_leaves_free_flight_alone():
    """A rotation by any angle a step leaves det F as it is; what a spin stretches is little."""
    spun = Placed(explicit_bar(CellType.HEXA8), velocity=(1.0, 0, 0), angular_velocity=(0.0, 0.0, 1e-3))
    e = simulate(System([spun]), Run(1.0, 0.5)).series["energies"]
    assert abs(e[-1, 5]) < 1e-12 * e[0, 0]


def test_coefficients_are_no_negative_numbers():
    with pytest.raises(ModelError, match="quadratic bulk viscosity must be zero or positive"):
        BulkViscosity(0.06, -1.0)

"""The explicit march of finite elements: frequency, balance, damping, deletion, and how it ends."""

import numpy as np
import pytest
from fixtures.explicit_bars import KINDS, SOFT, bar, explicit_bar, stepped

from supple.body import LinearRayleighDamping
from supple.errors import ConvergenceError, ModelError
from supple.fem import lumped_mass
from supple.integrate import Run, run
from supple.machine import At, Contact, DeadForce, Placed, RigidPlane, Support, System
from supple.mesh import CellType
from supple.methods.explicit import ENERGIES, ExplicitEngine
from supple.methods.explicit.elements import BulkViscosity
from supple.methods.explicit.explicit_subdomain import explicit_subdomain
from supple.methods.explicit.materials import J2Plasticity, LinearHardening, NeoHookean


def marched(system, span, n=10, step=None, **more):
    own = stepped(Run(span, span / n), step)
    return run(ExplicitEngine(system, own), own.times, **more)


def balance(solution):
    """Sum of all energies less external work, relative to the largest there has been."""
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    return np.abs(total - total[0]).max() / np.abs(e).max()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_bar_that_flies_turns_and_bounces_keeps_its_balance(kind):
    part = Placed(explicit_bar(kind), velocity=(0.5, 0, 0), angular_velocity=(0.1, 0, 0.3))
    wall = Contact(At("bar", "tip"), RigidPlane((4.1, 0, 0), (-1, 0, 0)))
    solution = marched(System([part], contacts=[wall], gravity=(0, 0, -0.1)), 1.0)
    energies = solution.series[ENERGIES]
    assert balance(solution) < 1e-12
    assert energies[:, 4].max() > 1e-3  # contact
    assert energies[:, 1].max() > 1e-2  # strain


def test_small_vibrations_have_the_frequency_of_the_lumped_model():
    model = bar(CellType.TETRA4)
    K = model.stiffness.toarray()
    m = lumped_mass(model)
    values, vectors = np.linalg.eigh(K / np.sqrt(m[:, None] * m))
    mode = vectors[:, 6] / np.sqrt(m)
    omega = np.sqrt(values[6])
    part = explicit_subdomain(model, name="bar")
    engine = ExplicitEngine(System([part]), Run(2 * np.pi / omega, 2 * np.pi / omega / 8))
    state = engine.start(0.0)._replace(v=1e-6 * np.asarray(mode).reshape(-1, 3).T, initial=np.array(0.5e-12))
    leg = engine.march(state, engine._run.times[1:])
    u = leg.states.x - np.asarray(engine.built.start.x)
    amplitudes = (u.swapaxes(1, 2).reshape(8, -1) * m) @ mode
    expected = 1e-6 / omega * np.sin(2 * np.pi * np.arange(1, 9) / 8)
    assert amplitudes == pytest.approx(expected, abs=0.02 * 1e-6 / omega)


def test_the_same_force_in_equal_parts_of_a_held_bar_settles_at_the_static_solution():
    """Mass damping leads to equilibrium, where the load is the internal force of the implicit model."""
    from supple.fem.quadratic_strain import internal_force

    model = bar(CellType.TETRA4)
    part = explicit_subdomain(model, name="bar", damping=LinearRayleighDamping(1.0, 0.0))
    system = System(
        [part],
        supports=[Support(At("bar", "root"))],
        loads=[DeadForce(at="bar.tip", force=(0.0, 0.0, 0.5))],
    )
    solution = marched(system, 60.0)
    u = solution.bodies["bar"].nodes[-1] - model.mesh.nodes
    assert np.abs(u).max() > 0.3
    own = model.blocks[0]
    force = np.zeros(model.n_dofs)
    np.add.at(force, own.dofs, internal_force(own, u.ravel()[own.dofs]))
    tip = model.mesh.node_sets["tip"]
    load = np.zeros_like(u)
    load[tip, 2] = 0.5 / len(tip)
    free = np.setdiff1d(np.arange(len(u)), model.mesh.node_sets["root"])
    assert force.reshape(-1, 3)[free] == pytest.approx(load[free], abs=1e-6)
    assert balance(solution) < 1e-12


@pytest.mark.slow
def test_stiffness_damping_takes_the_vibration_and_leaves_the_flight():
    part = Placed(
        explicit_bar(CellType.HEXA8, damping=LinearRayleighDamping(0.0, 0.01)), velocity=(0.5, 0, 0)
    )
    wall = Contact(At("bar", "tip"), RigidPlane((4.01, 0, 0), (-1, 0, 0)))
    solution = marched(System([part], contacts=[wall]), 6.0)
    e = solution.series[ENERGIES]
    v = solution.bodies["bar"].velocities[-1].mean(axis=0)
    assert balance(solution) < 1e-12
    assert e[-1, 5] > 1e-3  # damping
    assert e[-1, 0] == pytest.approx(0.5 * 4 * v[0] ** 2, rel=0.05)


@pytest.mark.slow
def test_elements_are_deleted_at_their_plastic_strain():
    law = J2Plasticity(SOFT, LinearHardening(1.0, 1.0))
    part = explicit_bar(CellType.HEXA8, law, deletion=0.1)
    pulled = System(
        [part],
        supports=[Support(At("bar", "root"))],
        loads=[DeadForce(at="bar.tip", force=(6.0, 0.0, 0.0))],
    )
    solution = marched(pulled, 3.0)
    alive = solution.bodies["bar"].alive[-1]
    assert 0 < alive.sum() < 4
    assert solution.bodies["bar"].plastic_strain[-1].max() >= 0.1
    assert balance(solution) < 1e-12


def test_a_run_ends_where_an_element_turns_over_and_keeps_what_was_computed():
    """Without bulk viscosity, which would hold it."""
    bar = explicit_bar(CellType.TETRA4, bulk_viscosity=BulkViscosity(0.0, 0.0))
    part = Placed(bar, velocity=(20.0, 0, 0))
    wall = Contact(At("bar", "tip"), RigidPlane((4.1, 0, 0), (-1, 0, 0)))
    kept = []
    with pytest.raises(ConvergenceError, match="an element inverted"):
        marched(System([part], contacts=[wall]), 1.0, 50, record=kept.append)
    assert sum(len(part.times) for part in kept) > 1


def test_a_step_above_the_limit_is_refused():
    part = explicit_bar(CellType.HEXA8)
    with pytest.raises(ModelError, match="above the stability limit"):
        marched(System([part]), 1.0, step=1.1 * part.step_limit)


def test_stiffness_damping_shortens_the_step_of_its_own_part_once():
    def step(*betas):
        parts = [
            explicit_subdomain(bar(CellType.HEXA8), name=f"bar {i}", damping=LinearRayleighDamping(0.0, beta))
            for i, beta in enumerate(betas)
        ]
        own = ExplicitEngine(System(parts), Run(100.0, 100.0))
        assert own.march(own.start(0.0), own._run.times[:1]).states.ratio == 1
        return own.steps()[0]

    beta = explicit_bar(CellType.HEXA8).step_limit
    assert step(beta) < 0.5 * step(0.0)
    assert step(*5 * [beta]) == pytest.approx(step(beta))
    assert step(beta, 0.0, 0.1 * beta) == pytest.approx(step(beta))


@pytest.mark.slow
def test_energy_from_nothing_stops_the_run():
    """A neo-Hookean bar that is crushed, and that nothing damps, hardens beyond what a fixed step allows."""
    none = BulkViscosity(0.0, 0.0)
    bar = explicit_bar(CellType.HEXA8, NeoHookean(SOFT), (8, 2, 2), bulk_viscosity=none)
    part = Placed(bar, velocity=(9.0, 0, 0))
    wall = Contact(At("bar", "tip"), RigidPlane((4.05, 0, 0), (-1, 0, 0)))
    step = 0.95 * part.body.step_limit / np.sqrt(1.2)
    with pytest.raises(ConvergenceError, match=r"negative|balance|inverted|not finite"):
        marched(System([part], contacts=[wall]), 1.0, 50, step)


def test_nodes_that_begin_inside_an_obstacle_are_refused():
    part = explicit_bar(CellType.HEXA8)
    wall = Contact(At("bar", "tip"), RigidPlane((3.9, 0, 0), (-1, 0, 0)))
    with pytest.raises(ModelError, match="inside the RigidPlane"):
        marched(System([part], contacts=[wall]), 1.0)

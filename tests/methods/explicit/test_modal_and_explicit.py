"""Modal sub-domains and explicit elements in one march: ties, subcycling, contact, files."""

from functools import cache

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, stepped
from fixtures.frame_momentum import nodal_momentum

from supple.body import flexible_body
from supple.errors import ModelError, ResultFileError
from supple.fem import solid_model
from supple.integrate import Run, run
from supple.machine import (
    At,
    Contact,
    FollowerForce,
    Placed,
    RigidSphere,
    System,
    Tie,
)
from supple.mesh import CellType, Mesh, block
from supple.methods.explicit import (
    ENERGIES,
    ExplicitEngine,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import NormalModes
from supple.simulation import simulate


def _block(start, length, cells, kind=CellType.TETRA4):
    mesh = block(length, 1, 1, *cells, kind)
    return solid_model(Mesh(mesh.nodes + np.array([start, 0, 0]), mesh.cells, mesh.node_sets), SOFT)


@cache
def modal_half(n_modes=20):
    return modal_subdomain(flexible_body("modal", _block(0, 4, (4, 1, 1))), NormalModes(n_modes))


def system(cells=(4, 1, 1), kind=CellType.TETRA4, within=1e-6, start=4.0, spin=(0.05, 0.02, 0.2), **more):
    explicit = explicit_subdomain(_block(start, 4, cells, kind), name="fe")
    parts = [Placed(modal_half(), angular_velocity=spin), Placed(explicit, angular_velocity=spin)]
    return System(parts, ties=[Tie(At("fe", "root"), "modal", within)], **more)


def momenta(solution, engine):
    """Linear and angular momentum (t, 6) over the step before each output time, from the nodes themselves."""
    built = engine.built
    h = solution.series["steps"][:, 0]
    fe = solution.bodies["fe"]
    before, push = nodal_momentum(engine, solution.times, "modal")
    m = np.asarray(built.model.mass)[built.nodes["fe"]][:, None]
    x = fe.nodes - h[:, None, None] * fe.velocities
    linear = push.sum(axis=1) + (m * fe.velocities).sum(axis=1)
    angular = np.cross(before, push).sum(axis=1) + np.cross(x, m * fe.velocities).sum(axis=1)
    return np.column_stack([linear, angular])[1:]


@pytest.mark.slow
def test_a_spinning_pair_in_equal_steps_keeps_momentum_energy_and_continuity():
    own = system()
    span = Run(40.0, 4.0)
    engine = ExplicitEngine(own, stepped(span, largest_ratio=1))
    solution = run(engine, span.times)
    p = momenta(solution, engine)
    assert np.abs(p - p[0]).max() < 1e-10 * np.abs(p).max()
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 1e-5
    modal = own.placed("modal").body.positions(solution.bodies["modal"])
    gap = (
        modal[:, own.node_numbers(At("modal", "tip"))]
        - solution.bodies["fe"].nodes[:, own.node_numbers(At("fe", "root"))]
    )
    assert np.abs(gap).max() < 1e-14 * 100


@pytest.mark.slow
def test_longer_steps_of_the_modes_change_little():
    span = Run(20.0, 5.0)
    ends = []
    for ratio in (1, 3):
        engine = ExplicitEngine(system(), stepped(span, step=0.008, largest_ratio=ratio))
        assert engine.steps()[1] == ratio
        solution = run(engine, span.times)
        ends.append(solution.bodies["fe"].nodes[-1])
        e = solution.series[ENERGIES][-1]
        assert abs(e[6]) < 1e-3 * e[0]  # the interface
    assert np.abs(ends[1] - ends[0]).max() < 1e-3 * np.abs(ends[0]).max()


def test_meshes_that_do_not_match_pass_the_patch_test():
    """Points of a finer mesh hang on the modal faces so that affine fields are theirs exactly."""
    own = system(cells=(2, 3, 3))
    built = ExplicitEngine(own, Run(1.0, 1.0)).built
    arrays = built.model.frames[0]
    body = own.placed("modal").body
    x = np.asarray(built.start.x).T[np.asarray(arrays.nodes)]
    assert len(x) == 16
    strain = np.array([[0.1, 0.02, 0.0], [0.0, -0.05, 0.03], [0.01, 0.0, 0.04]])
    field = (body.body.nodes @ strain.T).ravel()
    own_shapes = body.shapes @ built.frames["modal"].turned * body.points.arm
    flat = own_shapes.reshape(-1, body.n_modes)
    y = np.linalg.lstsq(flat, field, rcond=None)[0]
    left = field - flat @ y  # what the few modes miss, carried over linearly too
    at = np.einsum("nik,k->ni", np.asarray(arrays.shapes) * body.points.arm, y)
    assert np.asarray(arrays.weights).sum(axis=1) == pytest.approx(np.ones(16))
    assert np.abs(at - x @ strain.T).max() < np.abs(left).max() + 1e-12


@pytest.mark.slow
def test_a_ball_hits_the_modal_part_and_momentum_goes_over():
    ball = RigidSphere((2.0, 0.5, 1.05), 0.5, velocity=(0.0, 0.0, -0.5), mass=0.5)
    own = system(spin=(0, 0, 0), contacts=[Contact(At("modal", "z_max"), ball)])
    span = Run(4.0, 0.5)
    engine = ExplicitEngine(own, stepped(span, largest_ratio=1))
    solution = run(engine, span.times)
    p = momenta(solution, engine)[:, :3] + 0.5 * solution.series["obstacles"][1:, 3:]
    assert solution.series["obstacles"][-1, 5] > -0.4
    assert p == pytest.approx(np.broadcast_to([0, 0, -0.25], p.shape), abs=1e-11)
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total / total[0] - 1).max() < 5e-4


@pytest.mark.slow
def test_the_balance_is_closed_while_a_ball_hits_a_spinning_modal_part():
    """What a turn by a finite angle in a step does to the energy is known, and is little."""
    ball = RigidSphere((2.0, 0.5, 1.05), 0.5, velocity=(0.0, 0.0, -0.5), mass=0.5)
    own = system(spin=(0.02, 0.1, 0.05), contacts=[Contact(At("modal", "z_max"), ball)])
    span = Run(4.0, 0.5)
    solution = run(ExplicitEngine(own, stepped(span, largest_ratio=1)), span.times)
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(e[:, 4]).max() > 4e-4 * total[0]  # contact, at the output times
    assert np.abs(total / total[0] - 1).max() < 1e-10
    assert 1e-9 * total[0] < np.abs(e[:, 6]).max() < 1e-3 * total[0]  # interface, with the turn


@pytest.mark.slow
def test_a_force_that_follows_the_frame_turns_with_it():
    body = modal_half()
    force = FollowerForce(first=At("modal", "tip"), force=(0.0, 0.1, 0.0))
    solution = simulate(System([body], loads=[force]), Run(10.0, 0.05))
    rotation = solution.bodies["modal"].rotation[-1]
    assert rotation.T @ rotation == pytest.approx(np.eye(3), abs=1e-13)
    assert not np.allclose(rotation, np.eye(3), atol=0.1)
    e = solution.series[ENERGIES]
    assert e[-1, 0] + e[-1, 1] == pytest.approx(e[-1, 7], rel=1e-4)


def test_interfaces_that_do_not_meet_are_refused():
    with pytest.raises(ModelError, match="does not match the other"):
        ExplicitEngine(system(start=4.5), Run(1.0, 1.0))


@pytest.mark.slow
def test_a_run_that_was_cut_off_goes_on_to_the_last_bit(tmp_path):
    own, span = system(), Run(2.0, 0.2)
    whole = simulate(own, span, file=tmp_path / "whole.h5")

    class CutError(Exception):
        pass

    def cut(part):
        if part > 0.5:
            raise CutError

    with pytest.raises(CutError):
        simulate(own, span, file=tmp_path / "cut.h5", progress=cut)
    resumed = simulate(own, span, file=tmp_path / "cut.h5")
    for name, motion in whole.bodies.items():
        for field, values in motion.arrays().items():
            assert np.array_equal(values, resumed.bodies[name].arrays()[field]), (name, field)
    with pytest.raises(ResultFileError, match="another run"):
        simulate(own, Run(3.0, 0.2), file=tmp_path / "whole.h5")

"""Runs with padding coordinates against runs without."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space

from supple.body import AveragingInterface, MeanAxisFrame, flexible_body
from supple.errors import LockingWarning
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, Ball, Placed, System
from supple.mesh import CellType, block
from supple.methods.floating.compiled.every_step import every_step
from supple.programs.program_cache import CachedProgram
from supple.reduction import CompressedDerivatives, CraigBampton, NoLoads, PlainQuartic, padded, reduce
from supple.simulation import simulate

MESH = block(1.0, 0.05, 0.05, 4, 1, 1, CellType.HEXA20)
RUN = Run(0.2, 0.02, FixedStep(1e-3), tolerances=Tolerances(1e-10), method=GeneralizedAlpha(0.8))


def swinging(n_modes, *, room=True):
    """A rod on a ball joint, let go from the horizontal while it is bent and bends."""
    rubber = Isotropic(youngs_modulus=2.1e7, poissons_ratio=0.3, density=1000.0)
    near = AveragingInterface("near", (MESH.nodes[:, 0] < 1e-9).nonzero()[0])
    rod = flexible_body("rod", solid_model(MESH, rubber), [near])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LockingWarning)  # of so few columns; it runs all the same
        body = reduce(
            rod,
            MeanAxisFrame(),
            CraigBampton(n_modes),
            derivatives=CompressedDerivatives(6),
            quartic=PlainQuartic(),
            loads=NoLoads,
        )
    held = null_space(body.interface("near").motion[:3])
    bent = 1e-3 * held @ held[0]
    placed = Placed(padded(body) if room else body, coordinates=bent, coordinate_rates=bent)
    return System((placed,), (Ball(first=GROUND, second=At("rod", "near")),), gravity=(0.0, 0.0, -9.81))


@pytest.fixture(scope="module")
def system():
    return swinging(3)


@pytest.fixture(scope="module")
def roomy(system):
    return simulate(system, RUN)


def assert_same_motion(one, other, tolerance):
    for item in ("position", "rotation", "coordinates", "coordinate_rates"):
        own, exact = (getattr(each.bodies["rod"], item) for each in (one, other))
        exact = exact[-len(own) :]
        assert own.shape == exact.shape
        np.testing.assert_allclose(own, exact, rtol=0, atol=tolerance * np.abs(exact).max())


def test_they_change_nothing(system, roomy):
    assert system.bodies[0].body.padding > 0
    plain = simulate(swinging(3, room=False), RUN)
    assert_same_motion(roomy, plain, 1e-9)
    assert roomy.statistics.steps == plain.statistics.steps
    moved = np.abs(roomy.bodies["rod"].coordinates).max(axis=0)
    assert np.all(moved > 0)


def test_a_run_goes_on_to_the_last_digit(system, roomy):
    half = simulate(system, replace(RUN, duration=0.1))
    assert half.bodies["rod"].coordinates.shape[1] == system.bodies[0].body.r
    assert_same_motion(simulate(system, RUN, resume=half), roomy, 0.0)


@pytest.mark.parametrize("room", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_runs_with_and_without_room_go_on_from_each_other(room):
    """To the order of the method, as from a part that kept nothing of the integrator."""
    begun = simulate(swinging(3, room=room), RUN)
    longer, other = replace(RUN, duration=0.3), swinging(3, room=not room)
    assert_same_motion(simulate(other, longer, resume=begun), simulate(other, longer), 1e-3)


def test_every_step_is_told_in_the_own_coordinates(system, roomy):
    steps = every_step(system, RUN, roomy)
    assert len(steps.solution.times) == 201
    at_outputs = replace(
        steps.solution,
        bodies={name: own.at(steps.outputs) for name, own in steps.solution.bodies.items()},
    )
    assert_same_motion(at_outputs, roomy, 1e-12)


def test_another_number_of_modes_compiles_nothing(roomy, monkeypatch):
    def refuse(*_):
        raise AssertionError("a program was built")

    assert len(roomy.times) == 11
    monkeypatch.setattr(CachedProgram, "_found_or_built", refuse)
    more = swinging(4)
    assert more.bodies[0].body.r > swinging(3).bodies[0].body.r
    simulate(more, RUN)
    with pytest.raises(AssertionError, match="a program was built"):
        simulate(swinging(4, room=False), replace(RUN, duration=0.1))

"""Equilibrium at any deflection: elastica, a follower force, the 45-degree bend."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.equations import StaticSearch
from supple.errors import ConvergenceError, ModelError
from supple.integrate import FixedStep, GeneralizedAlpha, Run
from supple.machine import (
    Bushing,
    ConstantRate,
    DeadForce,
    Fixed,
    FollowerForce,
    Placed,
    PrescribedRotation,
    Spin,
    SpringDamper,
    System,
)
from supple.methods.intrinsic import CLAMPED, FREE, intrinsic_body
from supple.simulation import equilibrium, simulate
from supple_benchmarks.references.elastica import elastica

BEAM = {"EA": 1e6, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.01}
CLAMP = Fixed(first="ground", second="beam.root")


def tip_at_rest(n, load, *, points=None, **section):
    line = beam_line(straight(1.0, n) if points is None else points, **(BEAM | section))
    body = intrinsic_body(line, CLAMPED)
    rest = equilibrium(System([body], [CLAMP], [load])).solution.bodies
    rotations, positions = body.places(rest["beam"])
    return positions[0, -1], rotations[0, -1]


@pytest.mark.slow
def test_the_elastica_is_met_to_second_order():
    """P L^2 / EI = 10."""
    along, across, _ = elastica(1.0, 1.0, 10.0)
    errors = []
    for n in (10, 20, 40):
        tip, _ = tip_at_rest(n, DeadForce(at="beam.tip", force=(0, 0, 10.0)))
        errors.append(np.hypot(tip[0] - along, tip[2] - across))
    assert errors[-1] <= 2e-5
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) >= 1.9)


def follower_elastica(load):
    """Tip of an inextensible cantilever under a force that stays across its tip: shot from there."""
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def shot(turn):
        # phi: angle against the tip; the force is across the tip, M' = -P cos(phi).
        def rates(_, y):
            return [y[1], -load * np.cos(y[0] - turn), np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(rates, (1.0, 0.0), [turn, 0.0, 0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]

    turn = brentq(lambda angle: shot(angle)[0], 2.0, 3.0, xtol=1e-13)
    _, _, along, across = shot(turn)
    return np.array([-along, -across]), turn


@pytest.mark.slow
def test_a_follower_force_turns_the_tip_by_158_degrees():
    """P L^2 / EI = 8."""
    exact, turn = follower_elastica(8.0)
    assert np.degrees(turn) == pytest.approx(157.94, abs=0.01)
    errors = []
    for n in (10, 20):
        tip, rotation = tip_at_rest(n, FollowerForce(first="beam.tip", force=(0, 0, 8.0)))
        errors.append(np.linalg.norm(tip[[0, 2]] - exact))
        assert np.arctan2(-rotation[2, 0], rotation[0, 0]) == pytest.approx(-turn, abs=2e-3)
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) > 1.8


@pytest.mark.slow
def test_the_bend_of_45_degrees_stands_where_it_is_published():
    """Dead load 600 on the tip of an arc of radius 100; [SimoVuQuoc1986], part I: (15.79, 47.23, 53.37)."""
    angles = np.linspace(0, np.pi / 4, 17)
    points = np.column_stack([100 * (1 - np.cos(angles)), 100 * np.sin(angles), 0 * angles])
    EI = 1e7 / 12
    tip, _ = tip_at_rest(
        16,
        DeadForce(at="beam.tip", force=(0, 0, 600.0)),
        points=points,
        EA=1e7,
        EI=EI,
        GJ=EI,
        orientation=(0.0, 0.0, 1.0),
    )
    assert tip == pytest.approx([15.79, 47.23, 53.37], rel=0.01)


@pytest.mark.slow
def test_a_line_that_nothing_holds_falls():
    body = intrinsic_body(beam_line(straight(1.0, 4), **BEAM), FREE, 4)
    with pytest.raises(ConvergenceError, match="A body that is not supported"):
        equilibrium(System([body], gravity=(0, 0, -9.81)), search=StaticSearch(max_iterations=20))


@pytest.mark.slow
def test_a_run_from_the_equilibrium_of_a_beam_stays_there():
    """Its clamp carries the weight, and its moment about the root; a drive is held where its law is."""
    sag = 0.05
    drive = PrescribedRotation(
        name="drive", first="ground", second="beam.root", axis=(0, 0, 1), angle=ConstantRate(0.3)
    )
    body = intrinsic_body(beam_line(straight(1.0, 4), **BEAM), CLAMPED)
    found = equilibrium(System([body], [CLAMP], gravity=(0, 0, -8 * sag)))
    forces = found.joint_forces[CLAMP.name]
    assert forces[2] == pytest.approx(8 * sag, rel=1e-10)  # of a mass of 1
    assert forces[4] == pytest.approx(-4 * sag, rel=0.01)  # a little less than of the straight beam
    run = Run(0.1, 0.05, step=FixedStep(0.01), method=GeneralizedAlpha(1.0))
    moved = simulate(found.system, run).bodies["beam"].coordinates
    assert np.abs(moved[0]).max() > 0.01
    assert np.abs(moved - moved[0]).max() < 1e-12
    driven = equilibrium(System([body], [drive], gravity=(0, 0, -8 * sag)))
    assert driven.joint_forces["drive"][[0, 1, 2]] == pytest.approx([0, 0, 8 * sag], abs=1e-10)
    with pytest.raises(ModelError, match=r"its root is held against it.*Give a joint about the axis"):
        equilibrium(System([body], [CLAMP]), spin=Spin(1.0, (0, 0, 1)))


@pytest.mark.parametrize(
    "element",
    [
        pytest.param(Bushing(first="a.tip", second="b.tip", stiffness=[10.0] * 6), marks=pytest.mark.slow),
        SpringDamper(first="a.tip", second="b.tip", stiffness=10.0, rest_length=None),
    ],
    ids=["bushing", "spring"],
)
def test_an_element_between_two_lines_is_undeformed_where_they_start(element):
    """Two cantilevers a metre apart stay straight."""
    lines = [intrinsic_body(beam_line(straight(1.0, 4), name=name, **BEAM), CLAMPED) for name in "ab"]
    bodies = [Placed(lines[0]), Placed(lines[1], position=[0.0, 0.0, 1.0])]
    joints = [Fixed(first="ground", second=f"{name}.root") for name in "ab"]
    rest = equilibrium(System(bodies, joints, [element])).solution.bodies
    for height, name, line in zip((0.0, 1.0), "ab", lines, strict=True):
        assert line.places(rest[name])[1][0, -1] == pytest.approx([1.0, 0.0, height], abs=1e-9)

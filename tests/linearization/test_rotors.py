"""Whirl of rotors whose nodes have rotary inertia: in every frame and engine as closed forms say."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidInterface, superelement
from supple.equations import balances
from supple.errors import ModelError
from supple.integrate import FixedStep, Newmark, Run, Tolerances
from supple.linearization import CampbellDiagram, campbell_diagram, linearize, machine_modes, mode_names
from supple.machine import JournalBearing, Placed, Revolute, Spin, System, Unbalance
from supple.reduction import CompleteBasis, CraigBampton, NoDerivatives, NoLoads, NormalModes, reduce
from supple.results.mode_tables import speed_tables
from supple.simulation import simulate
from supple.units import UNNAMED
from supple_benchmarks.validation.rotors import (
    LALANNE,
    OVERHUNG,
    Disc,
    Rotor,
    RoundShaft,
    disc_on_massless_shaft,
    friswell_rotor,
    in_fixed_axes,
    lalanne_frequencies,
    rotor_body,
    turning_frequencies,
    whirl_of_timoshenko_shaft,
    whirls,
)

FRAMES = {"nodal-fixed": NodalFixedFrame("hub"), "mean-axis": MeanAxisFrame()}


@pytest.fixture(params=FRAMES)
def frame(request):
    return FRAMES[request.param]


@pytest.mark.parametrize("full", [False, True], ids=["reduced", "full"])
def test_a_disc_on_a_massless_shaft_whirls_as_its_formula(frame, full):
    """J_t w^2 - J_p W w - k = 0: in space 141.267 forward and 32.176 backward, turning 81.267 and 92.176."""
    found = turning_frequencies(disc_on_massless_shaft(), frame, 60.0, {"hub": None}, full=full)
    roots = np.roots([1.1, -2.0 * 60.0, -5000.0])
    np.testing.assert_allclose(found[1:3], sorted(abs(roots - 60.0)), rtol=1e-6)
    np.testing.assert_allclose(sorted(roots), [-32.176, 141.267], atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("full", [False, True], ids=["reduced", "full"])
def test_a_disc_of_beam_elements_whirls_as_a_timoshenko_shaft(frame, full):
    """The consistent rotary mass of the elements, of which a disc has one: the error falls with h^2."""
    expected = whirl_of_timoshenko_shaft(OVERHUNG, 600.0, [(-400.0, -50.0), (50.0, 900.0)])
    body = rotor_body(OVERHUNG, 0.05, {"hub": 0.0})
    found = whirls(turning_frequencies(body, frame, 600.0, {"hub": None}, full=full), expected, 600.0)
    np.testing.assert_allclose(found, expected, rtol=2e-4)


def test_discs_of_a_shaft_may_be_listed_in_any_order_but_must_be_on_it():
    """A shaft of two discs: the transfer matrix goes from the clamp to the tip, whatever their order."""
    shaft = RoundShaft(0.0, 0.5, 0.02)
    discs = Disc(0.5, 5.0, 0.1, 0.06), Disc(0.2, 3.0, 0.05, 0.03)
    material = OVERHUNG.material
    first, second = (
        whirl_of_timoshenko_shaft(Rotor(material, (shaft,), 0.9, each), 100.0, (50.0, 600.0))
        for each in (discs, discs[::-1])
    )
    np.testing.assert_allclose(first, second, rtol=1e-9)
    with pytest.raises(ModelError, match=r"disc at 0.6 m is not on the shaft"):
        Rotor(material, (shaft,), 0.9, (Disc(0.6, 5.0, 0.1, 0.06),))


def test_a_free_rotor_has_its_stiffness_at_rest_and_a_skew_gyroscopic_matrix(frame):
    """In axes that stand: K, and for every node -W J_p (theta_y theta_z' - theta_z theta_y')."""
    body, rate = disc_on_massless_shaft(), 60.0
    mass, gyroscopic, stiffness = in_fixed_axes(body, frame, rate)
    np.testing.assert_allclose(mass, body.mass.toarray(), atol=1e-9)
    np.testing.assert_allclose(stiffness, body.stiffness.toarray(), atol=1e-9 * abs(stiffness).max())
    polar = body.mass.diagonal().reshape(-1, 6)[:, 3]
    expected = np.zeros_like(mass)
    for node, inertia in enumerate(polar):
        y, z = 6 * node + 4, 6 * node + 5
        expected[y, z], expected[z, y] = rate * inertia, -rate * inertia
    np.testing.assert_allclose(gyroscopic, expected, atol=1e-9 * rate * polar.max())


def test_a_forward_whirl_is_followed_through_its_critical_speed():
    """K u = W^2 (M - G) u of Nelson's elements, 24 of them: 86.905 and 288.618 rad/s."""
    body = rotor_body(friswell_rotor(), 0.1, {"left": 0.0, "right": 1.5}).linearized()
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(10), derivatives=NoDerivatives(), loads=NoLoads)
    bearings = [
        JournalBearing(
            first="ground",
            second=f"rotor.{end}",
            axis=(1, 0, 0),
            stiffness=1e6 * np.eye(2),
            damping=500 * np.eye(2),
        )
        for end in ("left", "right")
    ]
    spins = [Spin(rate, (1, 0, 0)) for rate in np.linspace(0.0, 400.0, 5)]
    machine = System([reduced], loads=bearings)
    diagram = campbell_diagram(machine, spins, n_modes=6, fulls=())
    assert [each.rate for each in diagram.critical_speeds] == pytest.approx([86.905, 288.618], rel=5e-3)
    assert diagram.likeness[1:].min() > 0.99
    forward = np.array([name.startswith("forward") for name in diagram.names])
    # -Re(s) / |s| of the same elements at 400 rad/s, in space.
    assert diagram.observed_damping_ratios[-1, forward] == pytest.approx([0.009046, 0.042598], rel=0.01)
    assert not diagram.onsets
    back = campbell_diagram(machine, spins[::-1], n_modes=6, fulls=())
    assert [each.rate for each in back.critical_speeds] == pytest.approx([86.905, 288.618], rel=5e-3)
    assert "forward whirl 2" in back.names


def test_modes_of_an_unbalanced_shaft_of_beams_are_whirls_not_those_of_a_blade():
    body = rotor_body(friswell_rotor(), 0.5, {"left": 0.0, "disc": 1.0, "right": 1.5}).linearized()
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(2), derivatives=NoDerivatives(), loads=NoLoads)
    loads = [
        JournalBearing(first="ground", second=f"rotor.{end}", axis=(1, 0, 0), stiffness=1e6 * np.eye(2))
        for end in ("left", "right")
    ]
    loads.append(Unbalance(first="rotor.disc", moment=(0.0, 1e-3, 0.0)))
    modes = machine_modes(linearize(System([reduced], loads=loads), spin=Spin(60.0, (1, 0, 0)), fulls=()), 6)
    assert {name.rpartition(" ")[0] for name in mode_names(modes)} == {
        "rotor",
        "forward whirl",
        "backward whirl",
    }


def test_a_shaft_of_unequal_stiffness_is_unstable_between_its_critical_speeds():
    """A disc of 10 kg that is held in axes that turn by 100 and 144 kN/m: sqrt(k / m) = 100 and 120 rad/s."""
    springs = np.diag([1e8, 1e5, 1.44e5, 1e8, 1e6, 1e6])
    body = superelement(
        "rotor",
        np.zeros((2, 3)),
        np.kron([[1.0, -1.0], [-1.0, 1.0]], springs),
        np.diag([10.0, 10.0, 10.0, 3.0, 2.0, 2.0, 10.0, 10.0, 10.0, 0.2, 0.1, 0.1]),
        dofs_per_node=6,
        interfaces=[RigidInterface("hub", [0])],
    )
    reduced = reduce(body, NodalFixedFrame("hub"), CompleteBasis(), derivatives=NoDerivatives())
    hinge = Revolute(first="ground", second="rotor.hub", axis=(1, 0, 0))
    spins = [Spin(rate, (1, 0, 0)) for rate in np.linspace(0.0, 165.0, 12)]
    diagram = campbell_diagram(System([reduced], [hinge]), spins, n_modes=3, fulls=())
    assert [each.rate for each in diagram.critical_speeds] == pytest.approx([100.0, 120.0], rel=2e-3)
    (onset,) = diagram.onsets
    assert onset.rate == pytest.approx(100.0, rel=2e-3)
    # s^4 + (w1^2 + w2^2 + 2 W^2) s^2 + (w1^2 - W^2)(w2^2 - W^2) = 0 at 105 rad/s
    growth = np.sqrt(
        np.roots([1.0, 1e4 + 1.44e4 + 2 * 105.0**2, (1e4 - 105.0**2) * (1.44e4 - 105.0**2)]).max()
    )
    assert diagram.eigenvalues[7].real.max() == pytest.approx(growth, rel=1e-6)


def test_internal_damping_makes_the_whirl_of_jeffcotts_rotor_unstable():
    """m w'' + (c_e + c_i) w' + (k - i c_i W) w = 0, little damping: from (1 + c_e / c_i) sqrt(k / m) on."""
    external, internal, rates = 0.01, 0.02, np.linspace(0.0, 4.0, 9)
    in_space = np.array([np.roots([1.0, external + internal, 1.0 - 1j * internal * W]) for W in rates])
    forward = in_space[in_space.imag > 0]
    turning = forward.real + 1j * abs(forward.imag - rates)
    diagram = CampbellDiagram(
        rates,
        turning[:, None],
        np.ones((8, 1)),
        axes="turning with the machine",
        sense=np.ones((9, 1), dtype=int),
        in_space=forward.imag[:, None],
        names=("forward whirl 1",),
    )
    (onset,) = diagram.onsets
    assert onset.rate == pytest.approx(1 + external / internal, rel=1e-3)
    assert diagram.observed_damping_ratios[0, 0] == pytest.approx(0.015, rel=1e-6)
    tables = {table.title: table for table in speed_tables(diagram, UNNAMED)}
    assert tables["Damping over speed, of whirls in space"].rows[0][1] == "1.5"
    assert tables["Onset of instability"].rows == [["1.5", "forward whirl 1"]]


@pytest.mark.slow
def test_lalannes_rotor_of_three_discs():
    """On bearings that are not alike in all directions, 25 000 rpm."""
    for frame in (NodalFixedFrame("left"), MeanAxisFrame()):
        np.testing.assert_allclose(lalanne_frequencies(frame)[: len(LALANNE)], LALANNE, rtol=3e-3)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")
def test_a_free_gyroscopic_body_keeps_energy_and_angular_momentum():
    """The overhung disc, thrown while it spins about its shaft: what drifts is of the integrator's order."""
    body = rotor_body(OVERHUNG, 0.1, {"hub": 0.0})
    reduced = reduce(body, MeanAxisFrame(), NormalModes(6), derivatives=NoDerivatives(), loads=NoLoads)
    rates = np.zeros(reduced.r)
    rates[:2] = 0.05 * reduced.frequencies[:2]
    system = System((Placed(reduced, angular_velocity=[300.0, 30.0, 10.0], coordinate_rates=rates),))

    def drift(step):
        run = Run(0.01, 0.002, step=FixedStep(step), method=Newmark(), tolerances=Tolerances(residual=1e-11))
        kept = balances(system, simulate(system, run))
        return [
            np.abs(values - values[0]).max() / np.abs(values[0]).max()
            for values in (kept.total, kept.angular_momentum)
        ]

    coarse, fine = np.array(drift(4e-5)), np.array(drift(2e-5))
    assert (fine < 1e-4).all()
    assert (coarse / fine > 3.5).all()


def test_a_mode_without_a_match_has_no_damping_ratio_at_that_speed():
    """It is unknown there, not zero, in each kind of axes."""
    eigenvalues = np.array([[-0.3 + 0.4j, -1.0 + 0.0j], [np.nan + 0.0j, 0.0 + 0.0j]])
    diagram = CampbellDiagram(np.array([0.0, 1.0]), eigenvalues, np.ones((1, 2)))
    np.testing.assert_array_equal(diagram.damping_ratios, [[0.6, 1.0], [np.nan, 0.0]])
    np.testing.assert_array_equal(diagram.observed_damping_ratios, diagram.damping_ratios)

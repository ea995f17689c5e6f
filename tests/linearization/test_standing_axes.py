"""Machines that turn, seen in axes that stand: unlike bearings, blades on a yielding tower, Floquet."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from scipy.spatial.transform import Rotation

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import BasisWarning, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model, solid_model
from supple.linearization import (
    TranslationPort,
    campbell_diagram,
    frequency_response,
    linearize,
    linearize_in_space,
    machine_modes,
    mode_names,
    standing_axes,
    state_space,
    whirl,
)
from supple.machine import (
    At,
    Bushing,
    ConstantRate,
    Fixed,
    Gear,
    JournalBearing,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    Spin,
    System,
    TorsionSpringDamper,
    Universal,
)
from supple.mesh import CellType, cylinder, strip
from supple.reduction import CompleteBasis, CraigBampton, NoDerivatives, NoLoads, reduce
from supple_benchmarks.validation.rotors import (
    LALANNE,
    friswell_rotor,
    lalanne_frequencies,
    lalanne_rotor,
    rotor_body,
)

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
PITCH = Rotation.from_rotvec([0.3, 0, 0]).as_matrix()
"""Of a blade about its own axis: bending across the plane of the rotor and in it go together."""


def bearings(name, stiffness, damping=(0.0, 0.0)):
    """Two, unlike along y and z, of a rotor along x."""
    return [
        JournalBearing(
            first="ground",
            second=f"{name}.{end}",
            axis=X,
            x_axis=(0, 1, 0),
            stiffness=np.diag(stiffness),
            damping=np.diag(damping),
        )
        for end in ("left", "right")
    ]


class TestRigidRotor:
    """Translation along y and z alone; tilt by `I s^2 + k l^2` on the diagonal, `I_p W s` across."""

    mass, transverse, polar, arm, soft, stiff = 3.0, 0.2, 0.35, 0.4, 2e4, 5e4

    def machine(self, soft=None):
        points = {"left": [-self.arm, 0, 0], "right": [self.arm, 0, 0]}
        inertia = np.diag([self.polar, self.transverse, self.transverse])
        rotor = RigidBody("rotor", self.mass, np.zeros(3), inertia, points)
        return System([rotor], loads=bearings("rotor", (soft or self.soft, self.stiff)))

    def exact(self, rate, soft=None):
        """Backward and forward tilt, and both translations."""
        k = 2 * np.array([self.stiff, soft or self.soft])
        gyroscopic = self.polar * rate * np.array([[0, 1.0], [-1.0, 0]])
        zero, one, inertia = np.zeros((2, 2)), np.eye(2), self.transverse
        state = np.block([[zero, one], [-np.diag(k * self.arm**2) / inertia, -gyroscopic / inertia]])
        tilt = np.linalg.eigvals(state).imag
        return np.sort(tilt[tilt > 0]), np.sort(np.sqrt(k / self.mass))

    def test_on_unlike_bearings_it_has_the_frequencies_of_the_closed_form(self):
        rate = 150.0
        linear = linearize(self.machine(), spin=Spin(rate, X))
        modes = machine_modes(linear)
        tilt, centre = self.exact(rate)
        assert linear.axes == "standing in space"
        assert linear.periodic is None
        assert modes.frequencies[2:] == pytest.approx(np.sort([*tilt, *centre]), rel=1e-10)
        found = whirl(modes)
        by_frequency = dict(zip(np.round(found.frequencies[2:], 6), found.sense[2:], strict=True))
        assert by_frequency[round(tilt[0], 6)] == -1
        assert by_frequency[round(tilt[1], 6)] == 1
        assert [by_frequency[round(each, 6)] for each in centre] == [0, 0]  # along one line each

    def test_an_unbalance_as_small_as_that_of_a_free_mesh_does_not_prevent_modes(self):
        """Its centre is 1e-6 of its length off the axis: frequencies of the closed form."""
        machine, rate = self.machine(), 150.0
        rotor = replace(machine.bodies[0].body, centre=np.array([0.0, 1e-6 * self.arm, 0.0]))
        linear = linearize(replace(machine, bodies=(Placed(rotor),)), spin=Spin(rate, X))
        tilt, centre = self.exact(rate)
        found = machine_modes(linear).frequencies[2:]
        assert found == pytest.approx(np.sort([*tilt, *centre]), rel=1e-6)

    def test_the_response_between_ports_that_are_fixed_in_space_is_that_of_the_closed_form(self):
        """On like bearings too: `(2 k - m w^2) u = F` and `(2 k l^2 - I w^2) t + i w I_p W J t = l F J`."""
        rate, w, k = 150.0, 130.0, 2 * self.stiff
        ports = [TranslationPort("rotor.right", axis) for axis in np.eye(3)[1:]]
        linear = linearize_in_space(self.machine(self.stiff), spin=Spin(rate, X))
        found = frequency_response(state_space(linear, inputs=ports[:1], outputs=ports), [w]).transfer[
            0, :, 0
        ]
        # y + i z of the whirls: forward for exp(i w t), backward for exp(-i w t); half of F drives each.
        both = [
            0.5 / (k - self.mass * w**2)
            + 0.5 * self.arm**2 / (k * self.arm**2 - self.transverse * w**2 + sense * self.polar * rate * w)
            for sense in (1, -1)
        ]
        assert linear.axes == "standing in space"
        assert found == pytest.approx([sum(both), 1j * (both[1] - both[0])], rel=1e-8)

    def test_a_rotor_that_turns_freely_has_a_static_compliance_across_its_axis(self):
        """1 / (2 k) and l^2 / (2 k l^2) at an end; its rotation and its motion along the axis have none."""
        linear = linearize(self.machine(self.stiff))
        across, along = (TranslationPort("rotor.right", axis) for axis in ((0, 1, 0), X))
        found = frequency_response(state_space(linear, inputs=[across], outputs=[across]), [0.0, 10.0])
        assert found.transfer[0, 0, 0] == pytest.approx(1 / self.stiff, rel=1e-9)
        with pytest.raises(ModelError, match=r"moves .* without end"):
            frequency_response(state_space(linear, inputs=[along], outputs=[along]), [0.0])

    def test_on_like_bearings_the_whirl_in_space_is_that_of_the_closed_form(self):
        """In turning axes the same motions are seen W lower and higher."""
        rate = 150.0
        linear = linearize(self.machine(self.stiff), spin=Spin(-rate, X))
        modes = machine_modes(linear)
        tilt, centre = self.exact(rate, self.stiff)
        assert linear.axes == "turning with the machine"
        found = whirl(modes)
        whirls, senses = found.frequencies[found.sense != 0], found.sense[found.sense != 0]
        # Both whirls of the centre have one frequency: rounding must not order them.
        shown = sorted(zip(np.round(whirls, 6), senses, strict=True))
        expected = sorted([(tilt[0], -1), (tilt[1], 1), (centre[0], -1), (centre[1], 1)])
        assert [each for each, _ in shown] == pytest.approx([each for each, _ in expected], rel=1e-9)
        assert [sense for _, sense in shown] == [sense for _, sense in expected]
        kinds = {
            name.rpartition(" ")[0]
            for name, sense in zip(mode_names(modes), found.sense, strict=True)
            if sense
        }
        assert kinds == {"forward whirl", "backward whirl"}

    @pytest.mark.parametrize("like", [pytest.param(True, marks=pytest.mark.slow), False])
    def test_critical_speeds_are_where_a_whirl_has_the_rate_of_the_spin(self, like):
        """Of the discs alone: `w = W` where `(I - I_p) W^2 = k l^2` never is, for I_p > I; translation is."""
        soft = self.stiff if like else self.soft
        rates = np.linspace(0.0, 250.0, 11)
        diagram = campbell_diagram(self.machine(soft), [Spin(rate, X) for rate in rates], n_modes=6)
        _, centre = self.exact(1.0, soft)
        found = [each.rate for each in diagram.critical_speeds]
        # A backward tilt crosses too; straight lines are exact for what does not depend on W.
        for each in centre:
            assert min(abs(np.array(found) - each)) < 1e-6 * each
        assert len(found) == (1 if like else 3)
        assert diagram.axes == ("turning with the machine" if like else "standing in space")


@pytest.mark.slow
def test_lalannes_rotor_by_the_machine_itself():
    """Three discs on unlike bearings at 25 000 rpm, [Lalanne1998]: 46 coordinates of a reduced body."""
    body = rotor_body(lalanne_rotor(), 0.05, {"left": 0.0, "right": 1.3}).linearized()
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(40), derivatives=NoDerivatives(), loads=NoLoads)
    machine = System([reduced], loads=bearings(reduced.name, (5e7, 7e7), (5e2, 7e2)))
    linear = linearize(machine, spin=Spin(25_000 * np.pi / 30, X), fulls=())
    assert linear.periodic is None
    found = machine_modes(linear, 16).frequencies / (2 * np.pi)
    whole = lalanne_frequencies(MeanAxisFrame())[: len(LALANNE)]
    for each, published in zip(whole, LALANNE, strict=True):
        nearest = found[np.argmin(abs(found - each))]
        assert nearest == pytest.approx(each, rel=5e-5)
        assert nearest == pytest.approx(published, rel=2e-3)


def test_a_basis_that_cuts_a_pair_of_modes_still_names_the_frequencies_in_space():
    """Whirls 5 and 6 on damped bearings, of 24 elements by Nelson: 679.4 and 883.4 rad/s, not W apart."""
    body = rotor_body(friswell_rotor(), 0.1, {"left": 0.0, "right": 1.5}).linearized()
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(9), derivatives=NoDerivatives(), loads=NoLoads)
    machine = System([reduced], loads=bearings("rotor", (1e6, 2e6), (2e3, 2e3)))
    with pytest.warns(BasisWarning, match="'rotor'.* a pair of equal modes is cut"):
        linear = linearize(machine, spin=Spin(418.879, X), fulls=())
    modes = machine_modes(linear, 10)
    assert modes.machine.periodic is not None
    for whirl_in_space in (86.66, 96.89, 273.17, 340.78, 679.37, 883.42):
        assert np.min(abs(modes.frequencies - whirl_in_space)) < 0.01 * whirl_in_space


@pytest.mark.slow
def test_the_error_of_a_rotor_on_unlike_bearings_is_that_of_its_basis():
    """All coordinates in fixed axes, which share nothing with multi-blade ones or turned shapes."""
    body = rotor_body(lalanne_rotor(), 0.05, {"left": 0.0, "right": 1.3}).linearized()
    reduced = reduce(body, MeanAxisFrame(), CraigBampton(4), derivatives=NoDerivatives(), loads=NoLoads)
    machine = System([reduced], loads=bearings(reduced.name, (5e7, 7e7), (5e2, 7e2)))
    linear = linearize(machine, spin=Spin(25_000 * np.pi / 30, X))
    with pytest.warns(BasisWarning, match="are missing"):
        modes = machine_modes(linear, 9)  # the first two are motions along and about the axis
    error, exact = modes.error, lalanne_frequencies(MeanAxisFrame())
    found = np.array([*error.eigenvalues, *error.missed]).imag / (2 * np.pi)
    assert len(error.missed) == 1
    assert np.max(np.min(abs(exact[:7, None] - found), axis=1) / exact[:7]) < 1e-5
    assert modes.eigenvalues[:2] == pytest.approx(np.zeros(2))
    off = abs(modes.eigenvalues - error.eigenvalues)[2:] / abs(error.eigenvalues[2:])
    assert error.relative[2:] == pytest.approx(off)
    assert error.relative.max() > 0.1


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:body 'blade[012]' is linear")  # both machines have linear blades
def test_the_error_of_blades_on_a_tower_is_that_of_their_basis():
    """The same blades with all their coordinates as a basis, in the same axes."""
    model = shell_model(strip(1.0, 0.1, 3, 2), HomogeneousSection(Isotropic(2e9, 0.3, 2000.0), 0.02))
    angles = 2 * np.pi * np.arange(3) / 3
    points = {f"h{i}": 0.1 * np.array([np.cos(a), np.sin(a), 0]) for i, a in enumerate(angles)}
    still = np.zeros(3), np.eye(3)

    def machine(basis):
        bodies = [
            RigidBody("nacelle", 3.0, *still, {"c": np.zeros(3)}),
            RigidBody("hub", 1.0, *still, {"c": np.zeros(3), **points}),
        ]
        joints = [
            PrescribedRotation(
                first="nacelle.c", second="hub.c", axis=Z, angle=ConstantRate(1.0), name="drive"
            )
        ]
        for i, angle in enumerate(angles):
            elastic = flexible_body(f"blade{i}", model, [RigidInterface("root", "root")]).linearized()
            own = reduce(elastic, NodalFixedFrame("root"), basis, derivatives=NoDerivatives(), loads=NoLoads)
            turned = Rotation.from_rotvec([0, 0, angle]).as_matrix() @ PITCH
            bodies.append(Placed(own, position=points[f"h{i}"], rotation=turned))
            joints.append(Fixed(first=f"hub.h{i}", second=f"blade{i}.root", name=f"fit{i}"))
        tower = Bushing(first="ground", second="nacelle.c", stiffness=(4e3, 9e3, 2e4, 3e3, 2e3, 4e3))
        return System(bodies, joints, [tower])

    spin = Spin(15.0, Z, bodies=["hub", "blade0", "blade1", "blade2"])
    with pytest.warns(BasisWarning, match="off by"):
        modes = machine_modes(linearize(machine(CraigBampton(2)), spin=spin), 10)
    complete = linearize(machine(CompleteBasis()), spin=spin, fulls=())
    assert complete.axes == modes.machine.axes == "standing in space"
    exact = machine_modes(complete, 16).eigenvalues
    known = np.isfinite(modes.error.relative)
    assert known.sum() >= 8
    nearest = np.min(abs(modes.error.eigenvalues[known, None] - exact), axis=1)
    assert np.max(nearest / abs(modes.error.eigenvalues[known])) < 1e-5
    assert modes.error.relative[known].max() > 1e-3


def turned_shaft(stiffness):
    """A shaft of hexahedra with a rigid disc at its end; four equal sectors of elements."""
    mesh = cylinder(0.05, 1.0, 2, 1, 5, CellType.HEXA8)
    ends = [RigidInterface("left", "root"), RigidInterface("right", "tip")]
    shaft = flexible_body("shaft", solid_model(mesh, Isotropic(2.1e11, 0.3, 7850.0)), ends).linearized()
    reduced = reduce(shaft, MeanAxisFrame(), CraigBampton(6), derivatives=NoDerivatives(), loads=NoLoads)
    disc = RigidBody("disc", 20.0, np.zeros(3), np.diag([0.4, 0.2, 0.2]), {"hub": np.zeros(3)})
    fit = Fixed(first="shaft.right", second="disc.hub", name="fit")
    return System([reduced, Placed(disc, position=X)], [fit], loads=bearings("shaft", stiffness))


@pytest.mark.slow
def test_a_shaft_of_solid_elements_in_both_axes(monkeypatch):
    """On like bearings, frequencies in axes that stand are those in turning axes less or more the rate."""
    rate, machine = 300.0, turned_shaft((3e6, 3e6))
    turning = machine_modes(linearize(machine, spin=Spin(rate, X), fulls=()), 9)
    shown = whirl(turning)
    monkeypatch.setattr(sys.modules["supple.linearization.linearize"], "_change", lambda *_: ("tried", 1.0))
    linear = linearize(machine, spin=Spin(rate, X), fulls=())
    assert linear.periodic is None
    standing = machine_modes(linear, 9)
    for each in shown.frequencies[shown.sense != 0]:
        assert np.min(abs(standing.frequencies - each)) < 1e-8 * each
    assert np.count_nonzero(shown.sense) == 6


@pytest.mark.slow
def test_floquet_finds_what_axes_that_stand_do(monkeypatch):
    """The deformation left in turning axes makes the equations periodic; their modes are the same."""
    machine, spin = turned_shaft((3e6, 6e6)), Spin(300.0, X)
    constant = machine_modes(linearize(machine, spin=spin, fulls=()), 8).frequencies
    monkeypatch.setattr("supple.linearization.standing_axes.turn_generator", lambda *_: None)
    linear = linearize(machine, spin=spin, fulls=())
    assert linear.periodic is not None
    found = machine_modes(linear, 8).frequencies
    # Of a motion at s, s + i h W is another word: which one is named is where most is seen.
    apart = (found[:, None] - constant + 150.0) % 300.0 - 150.0
    assert np.max(np.min(abs(apart), axis=1)) < 1e-5 * constant.max()
    assert found[2:6] == pytest.approx(constant[2:6], rel=1e-6)
    with pytest.raises(ModelError, match="are periodic"):
        state_space(
            linear,
            inputs=[TranslationPort("disc.hub", (0, 1, 0))],
            outputs=[TranslationPort("disc.hub", (0, 1, 0))],
        )


@pytest.mark.slow
def test_multi_blade_coordinates_of_many_blades_have_the_derivatives_of_their_waves():
    """Of 90 blades waves of up to 44 around: more than 64 angles of a turn hold."""
    number, order = 90, 44
    fine = 3 * number
    angles = 2 * np.pi * np.arange(fine) / fine
    waves = standing_axes._Coordinates.of_fine(standing_axes._waves(number, angles), 10)
    at = angles[:: fine // 10, None] + 2 * np.pi * np.arange(number) / number
    np.testing.assert_allclose(waves.second[:, :, 2 * order - 1], -(order**2) * np.cos(order * at), atol=1e-8)


class TestGroundResonance:
    """Hammond's rotor: a hub on two springs, and blades on lag hinges [Hammond1974], [ColemanFeingold1958].

    I z_i'' + c z_i' + (k + W^2 e S) z_i = S (x'' sin psi_i - y'' cos psi_i)
    M_x x'' + k_x x = S sum [ (z_i'' - W^2 z_i) sin psi_i + 2 W z_i' cos psi_i ]
    M_y y'' + k_y y = - S sum [ (z_i'' - W^2 z_i) cos psi_i - 2 W z_i' sin psi_i ]
    """

    blade, inertia, centre, hinge = 1.0, 0.4, 0.5, 0.1
    carriage, nacelle, hub = 0.5, 8.0, 2.0
    springs, spring, damping = (900.0, 2500.0), 3.0, 0.02

    def machine(self, number, blades=None):
        """Hub and tower of rigid bodies, `number` blades evenly around; some of them of another mass."""
        angles = 2 * np.pi * np.arange(number) / number
        points = {f"h{i}": self.hinge * np.array([np.cos(a), np.sin(a), 0]) for i, a in enumerate(angles)}
        still = np.zeros(3), np.eye(3)
        bodies = [
            RigidBody("nacelle", self.nacelle, *still, {"c": np.zeros(3)}),
            RigidBody("carriage", self.carriage, *still, {"c": np.zeros(3)}),
            RigidBody("hub", self.hub, *still, {"c": np.zeros(3), **points}),
        ]
        joints = [
            Prismatic(first="ground", second="carriage.c", axis=X, name="x"),
            Prismatic(first="carriage.c", second="nacelle.c", axis=(0, 1, 0), name="y"),
            PrescribedRotation(
                first="nacelle.c", second="hub.c", axis=Z, angle=ConstantRate(1.0), name="drive"
            ),
        ]
        loads = [Bushing(first="ground", second="nacelle.c", stiffness=(*self.springs, 0, 0, 0, 0))]
        for i, angle in enumerate(angles):
            turned = np.array(
                [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
            )
            own = np.diag([0.01, self.inertia, self.inertia])
            mass = self.blade if blades is None else blades[i]
            body = RigidBody(f"blade{i}", mass, [self.centre, 0, 0], own, {"root": np.zeros(3)})
            bodies.append(Placed(body, position=points[f"h{i}"], rotation=turned))
            ends = {"first": f"hub.h{i}", "second": f"blade{i}.root", "axis": Z}
            joints.append(Revolute(**ends, name=f"lag{i}"))
            loads.append(TorsionSpringDamper(**ends, stiffness=self.spring, damping=self.damping))
        return System(bodies, joints, loads)

    def spin(self, number, rate):
        return Spin(rate, Z, bodies=["hub", *(f"blade{i}" for i in range(number))])

    def matrices(self, masses, rate, psi):
        """At angles (k,) of the rotor, (k, n, n) each."""
        number = len(masses)
        M, C, K = np.zeros((3, 2 + number, 2 + number, len(psi)))
        M[0, 0] = self.carriage + self.nacelle + self.hub + sum(masses)
        M[1, 1] = M[0, 0] - self.carriage
        K[0, 0], K[1, 1] = self.springs
        for i, mass in enumerate(masses):
            s, c = np.sin(psi + 2 * np.pi * i / number), np.cos(psi + 2 * np.pi * i / number)
            S, j = mass * self.centre, 2 + i
            M[j, j], C[j, j] = self.inertia + mass * self.centre**2, self.damping
            K[j, j] = self.spring + rate**2 * self.hinge * S
            M[j, 0] = M[0, j] = -S * s
            M[j, 1] = M[1, j] = S * c
            C[0, j], C[1, j] = -2 * rate * S * c, -2 * rate * S * s
            K[0, j], K[1, j] = rate**2 * S * s, -(rate**2) * S * c
        return [np.moveaxis(each, 2, 0) for each in (M, C, K)]

    def exponents(self, masses, rate, steps=800):
        """Floquet exponents, by the monodromy matrix of the equations above (Runge-Kutta)."""
        n, period = 2 + len(masses), 2 * np.pi / rate

        h, turned = period / steps, np.eye(2 * n)
        M, C, K = self.matrices(masses, rate, rate * h / 2 * np.arange(2 * steps + 1))
        states = np.zeros((len(M), 2 * n, 2 * n))
        states[:, :n, n:] = np.eye(n)
        states[:, n:] = -np.linalg.solve(M, np.concatenate([K, C], axis=2))
        for first, middle, last in zip(states[:-2:2], states[1:-1:2], states[2::2], strict=True):
            k1 = first @ turned
            k2 = middle @ (turned + h / 2 * k1)
            k3 = middle @ (turned + h / 2 * k2)
            k4 = last @ (turned + h * k3)
            turned = turned + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return np.log(np.linalg.eigvals(turned).astype(complex)) / period

    def check(self, linear, masses, rate):
        modes, exact = machine_modes(linear), self.exponents(masses, rate)
        assert len(modes.eigenvalues) == 2 + len(masses)
        for each in modes.eigenvalues:
            apart = abs((each - exact).real) + abs(((each - exact).imag + rate / 2) % rate - rate / 2)
            assert apart.min() < 1e-7 * rate
        return modes

    @pytest.mark.slow
    def test_three_blades_have_constant_equations_in_multi_blade_coordinates(self):
        rate, masses = 12.0, [self.blade] * 3
        linear = linearize(self.machine(3), spin=self.spin(3, rate))
        assert linear.axes == "standing in space"
        assert linear.periodic is None
        modes = self.check(linear, masses, rate)
        assert modes.eigenvalues.real.max() > 0.5  # it grows: ground resonance
        assert modes.unstable.sum() == 1
        # The collective lag of all blades does not move the hub: their own frequency and damping.
        S, inertia = self.blade * self.centre, self.inertia + self.blade * self.centre**2
        own = np.roots([inertia, self.damping, self.spring + rate**2 * self.hinge * S])
        assert np.min(abs(modes.eigenvalues - own[0])) < 1e-9 * rate
        # In space as on a hub that stands still: forward and backward at w + W and |w - W|, here coupled.
        assert "blade0" not in {name.rpartition(" ")[0] for name in mode_names(modes)}

    @pytest.mark.slow
    @pytest.mark.parametrize("number", [2, 4])
    def test_other_numbers_of_blades(self, number):
        for rate in (6.0, 12.0):
            linear = linearize(self.machine(number), spin=self.spin(number, rate))
            assert (linear.periodic is None) == (number == 4)
            self.check(linear, [self.blade] * number, rate)

    @pytest.mark.slow
    def test_a_heavier_blade_goes_round_and_pushes_the_hub_and_nothing_rests(self):
        with pytest.raises(ModelError, match="neither standing axes nor Floquet"):
            linearize(self.machine(3, [1.0, 1.0, 1.3]), spin=self.spin(3, 6.0))


def two_wheels(loads, joints=()):
    """Along x, a metre apart."""
    inertia = np.diag([0.1, 0.06, 0.06])
    wheels = [RigidBody(name, 1.0, np.zeros(3), inertia, {"c": np.zeros(3)}) for name in ("a", "b")]
    hinges = [Revolute(first="ground", second=f"{name}.c", axis=X, name=name) for name in ("a", "b")]
    return System([wheels[0], Placed(wheels[1], position=(0, 1.0, 0))], joints or hinges, loads)


@pytest.mark.slow
def test_what_repeats_at_even_angles_of_a_turn_is_not_taken_for_constant():
    """A gear to a wheel that stands, of as many teeth as three to every angle that is looked at."""
    mesh = Gear(first="a.c", second="b.c", axis=X, teeth=(21, 21), stiffness=1e4)
    spring = TorsionSpringDamper(first="ground", second="b.c", axis=X, stiffness=50.0)
    with pytest.raises(ModelError, match="the balance by"):
        linearize(two_wheels([mesh, spring]), spin=Spin(10.0, X, bodies=["a"]))


def test_a_second_speed_is_refused():
    drives = [
        PrescribedRotation(first="ground", second=f"{name}.c", axis=X, angle=ConstantRate(rate), name=name)
        for name, rate in (("a", 10.0), ("b", 25.0))
    ]
    with pytest.raises(ModelError, match=r"joint 'b' rotates at 25 .* two speeds are not linearised"):
        linearize(two_wheels([], drives), spin=Spin(10.0, X, bodies=["a"]))


def test_what_changes_of_itself_is_refused():
    machine = TestRigidRotor().machine()
    with pytest.raises(ModelError, match="gravity or loads normal to the axis"):
        linearize(replace(machine, gravity=(0.0, 0.0, -9.81)), spin=Spin(150.0, X))


def test_modes_of_a_blade_are_named_by_the_way_that_it_moves():
    """A flat strip that turns about z bends across its plane first; about an axis in it, that is edge."""
    model = shell_model(strip(1.0, 0.1, 12, 2), HomogeneousSection(Isotropic(2e11, 0.3, 7800.0), 0.01))
    flat = flexible_body("strip", model, [RigidInterface("root", "root")])
    reduced = reduce(flat, NodalFixedFrame("root"), CraigBampton(6), loads=NoLoads)
    hub = PrescribedRotation(first="ground", second=f"{reduced.name}.root", axis=Z, angle=0.0, name="hub")
    turned = System([reduced], [hub])
    names = mode_names(machine_modes(linearize(turned, spin=Spin(0.0, Z), fulls=()), 5))
    # Bending at 8.2 and 51 Hz, edge at 82, bending at 144, twist at (2 t / b) sqrt(G / rho) / 4 L = 157 Hz.
    assert names == ("flap 1", "flap 2", "edge 1", "flap 3", "torsion 1")
    across = PrescribedRotation(first="ground", second=f"{reduced.name}.root", axis=(0, 1, 0), angle=0.0)
    turned = System([reduced], [across])
    assert mode_names(machine_modes(linearize(turned, spin=Spin(0.0, (0, 1, 0)), fulls=()), 1)) == ("edge 1",)


def test_torsion_of_a_blade_of_beams_is_named():
    """Its nodes are on its axis: they do not move in torsion, at sqrt(G J / rho I_p) / 4 L = 125 Hz."""
    body = beam_body("root", n=6)
    reduced = reduce(body, NodalFixedFrame("root"), CraigBampton(6), loads=NoLoads)
    hub = PrescribedRotation(first="ground", second="beams.root", axis=Z, angle=0.0, name="hub")
    modes = machine_modes(linearize(System([reduced], [hub]), spin=Spin(0.0, Z), fulls=()), 6)
    assert modes.frequencies[5] / (2 * np.pi) == pytest.approx(124.8, rel=0.01)
    assert mode_names(modes)[5] == "torsion 1"


def test_a_universal_joint_to_the_ground_belongs_on_a_hub():
    """Hinges of a blade at the distance e from the axis: w = W sqrt(1 + 3 e / (2 L)) in flap."""
    e, length, rate = 0.2, 4.0, 20.0
    end = RigidBody("blade", 30.0, (length / 2, 0, 0), 40.0 * np.diag([1e-3, 1, 1]), {"root": (0, 0, 0)})
    blade = Placed(end, position=(e, 0, 0))
    hinges = Universal(
        first="ground", second="blade.root", first_axis=(0, 1, 0), second_axis=Z, name="hinges"
    )
    with pytest.raises(ModelError, match="joint 'hinges' connects one to the ground: if there is a hub"):
        linearize(System([blade], [hinges]), spin=Spin(rate, Z))
    hub = RigidBody("hub", 5.0, np.zeros(3), np.eye(3), {"shaft": (0, 0, 0), "end": (e, 0, 0)})
    shaft = PrescribedRotation(first="ground", second="hub.shaft", axis=Z, angle=0.0, name="shaft")
    turned = System([hub, blade], [shaft, replace(hinges, first=At("hub", "end"))])
    found = machine_modes(linearize(turned, spin=Spin(rate, Z))).frequencies
    assert found[1] == pytest.approx(rate * np.sqrt(1 + 1.5 * e / length), rel=2e-4)


def test_a_bushing_against_tilt_belongs_on_a_bearing_that_stands():
    """Of one on the rotor the stiffness against tilt grows with the angle of rotation.

    A disc on a bearing that stands: J w^2 -+ J_p W w - k = 0.
    """
    transverse, polar, stiffness, rate = 0.2, 0.35, 1e4, 100.0
    inertia = np.diag([polar, transverse, transverse])
    disc = RigidBody("disc", 10.0, np.zeros(3), inertia, {"c": np.zeros(3)})
    bearing = RigidBody("bearing", 1e-6, np.zeros(3), 1e-8 * np.eye(3), {"c": np.zeros(3)})
    hinge = Revolute(first="bearing.c", second="disc.c", axis=X, name="hinge")
    spin = Spin(rate, X, bodies=["disc"])

    def held(end, along_axis):
        springs = (4e5, 4e5, 1e6, stiffness, stiffness, along_axis)
        return Bushing(first="ground", second=end, axis=X, stiffness=springs)

    with pytest.raises(ModelError, match=r"changes with the angle of rotation.*by a Revolute joint"):
        linearize(System([disc], loads=[held("disc.c", 0.0)]), spin=spin)
    machine = System([disc, bearing], [hinge], [held("bearing.c", stiffness)])
    modes = machine_modes(linearize(machine, spin=spin))
    found = np.sort(modes.frequencies[whirl(modes).sense != 0])
    roots = np.roots([transverse, -polar * rate, -stiffness])
    np.testing.assert_allclose(found, np.sort(abs(roots)), rtol=1e-4)

"""Few modes of a body that bends far or spins: axial force and foreshortening of second-order modes."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight
from scipy import linalg

from supple.body import ModalDamping
from supple.errors import ModelError
from supple.machine import DeadForce, Fixed, FollowerTorque, System
from supple.methods.intrinsic import BALL, CLAMPED, FREE, hinged, intrinsic_body, released
from supple.methods.intrinsic.intrinsic_modes import intrinsic_modes
from supple.methods.intrinsic.second_order_modes import second_order_shapes
from supple.simulation import equilibrium
from supple_benchmarks.references.elastica import elastica
from supple_benchmarks.validation.intrinsic_lines import spinning_frequencies

SLENDER = {"EA": 1e6, "EI": 1.0, "GJ": 1.0, "mass_per_length": 1.0, "radius": 0.005}
CLAMP = Fixed(first="ground", second="beam.root")


@pytest.fixture(scope="module")
def whole():
    return intrinsic_body(beam_line(straight(1.0, 20), **SLENDER), CLAMPED)


def tip_at_rest(body, *loads):
    rest = equilibrium(System([body], [CLAMP], loads)).solution.bodies
    return body.places(rest["beam"])[1][0, -1]


@pytest.mark.parametrize("n", [6, *(pytest.param(n, marks=pytest.mark.slow) for n in (12, 24))])
def test_few_modes_stand_on_the_elastica(whole, n):
    """P L^2 / EI = 10; the lowest modes alone are off by 17 % of the length, however many up to 24."""
    along, across, _ = elastica(1.0, 1.0, 10.0)
    tip = tip_at_rest(whole.truncated(n), DeadForce(at="beam.tip", force=(0, 0, 10.0)))
    assert np.hypot(tip[0] - along, tip[2] - across) < 1e-3


@pytest.mark.slow
def test_few_modes_bend_and_twist_in_space(whole):
    loads = (
        DeadForce(at="beam.tip", force=(0, 4.0, 8.0)),
        FollowerTorque(first="beam.tip", torque=(1.5, 0, 0)),
    )
    exact = tip_at_rest(whole, *loads)
    assert np.linalg.norm(tip_at_rest(whole.truncated(10), *loads) - exact) < 3e-3


@pytest.mark.parametrize(
    ("speed", "lag", "flap"), [(0.0, 3.516, 3.516), (6.0, 4.26, 7.36), (12.0, 5.43, 13.17)]
)
def test_a_spinning_cantilever_of_ten_modes_stiffens(whole, speed, lag, flap):
    """Flap: Wright et al. 1982, table 1; lag^2 = flap^2 - speed^2. All modes of 20 segments: within 0.6 %."""
    found = spinning_frequencies(whole.truncated(10), speed)
    assert found[:2] == pytest.approx([lag, flap], rel=0.01)


def test_the_lowest_modes_are_eigenmodes_and_the_others_lie_above(whole):
    modes = whole.truncated(8).modes
    assert modes.n_second_order > 0
    assert modes.frequencies == pytest.approx(whole.modes.omega[:8], rel=1e-12)
    assert modes.omega[8:].min() >= whole.modes.omega[8] * (1 - 1e-9)
    assert max(modes.orthonormality) < 1e-9
    assert max(whole.modes.omega[8:]) >= modes.omega.max()
    assert modes.truncated(10).n_second_order == 2
    assert modes.truncated(6).n_second_order == 0


def test_shapes_of_a_free_line_hold_what_its_bent_form_carries_when_it_moves():
    """A bent line that turns rigidly has velocities outside its rigid modes."""
    modes = intrinsic_modes(beam_line(straight(1.0, 10), **SLENDER), FREE)
    shapes = second_order_shapes(modes, 4)
    bent = 0.3 * modes.strains[..., 0] / np.abs(modes.strains[..., 0]).max()
    twist = np.array([0, 0, 0, 0.4, 0.5, -0.3])
    middle = np.broadcast_to(twist, (10, 6)) + np.concatenate(
        [np.cross(twist[3:], modes.line.tree.middles), np.zeros((10, 3))], axis=1
    )
    turned = -np.concatenate(
        [
            np.cross(middle[:, 3:], bent[:, :3]) + np.cross(middle[:, :3], bent[:, 3:]),
            np.cross(middle[:, 3:], bent[:, 3:]),
        ],
        axis=1,
    )
    needed = np.einsum("sie,si,s->e", modes.forces, turned, modes.line.tree.lengths) / modes.omega[6:]
    left_out = needed - shapes @ (shapes.T @ needed)
    assert np.linalg.norm(left_out) < 0.02 * np.linalg.norm(needed)
    assert np.linalg.norm(needed[4:]) > 0.2 * np.linalg.norm(needed)


def test_a_released_body_keeps_what_its_modes_leave_out(whole):
    free = released(whole.truncated(6))
    assert free.complete is not None
    assert free.complete.n_coordinates == whole.n_coordinates
    added = free.modes.n_second_order - whole.truncated(6).modes.n_second_order
    assert 0 < added <= 6  # responses to forces and moments at its tip


@pytest.mark.parametrize("support", [CLAMPED, FREE, BALL, hinged((0, 1, 0))])
@pytest.mark.parametrize("end", [0, -1])
def test_a_released_body_clamped_at_either_end_vibrates_as_a_cantilever(support, end):
    """3.5160, lowered by 0.12 % by 20 segments; without static responses up to 33 % higher."""
    body = released(intrinsic_body(beam_line(straight(1.0, 20), **SLENDER), support, 6))
    assert body.supported.n_coordinates == body.n_coordinates
    assert cantilever_frequency(body, end) == pytest.approx(3.5160, rel=2e-3)


@pytest.mark.slow
def test_a_released_body_of_few_modes_held_at_its_tip_stands_on_the_elastica(whole):
    """P L^2 / EI = 10 at its root."""
    system = System(
        [released(whole.truncated(6))],
        [Fixed(first="ground", second="beam.tip")],
        [DeadForce(at="beam.root", force=(0, 0, 10.0))],
    )
    rest = equilibrium(system).solution.bodies["beam"]
    along, across, _ = elastica(1.0, 1.0, 10.0)
    root = system.bodies[0].body.places(rest)[1][0, 0]
    assert root == pytest.approx([1 - along, 0, across], abs=1e-3)


def test_a_released_body_of_few_modes_clamped_at_a_branch_vibrates_as_one_of_all_modes():
    """A fork: its tips clamped, the root free, and its branching point alone."""
    points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 1, 0], [4, 2, 0], [3, -1, 0], [4, -2, 0.5]]
    line = beam_line(np.array(points, dtype=float), parents=[-1, 0, 1, 2, 3, 2, 5], **SLENDER)
    assert line.tree.ends.tolist() == [0, 2, 4, 6]
    few, every = (released(intrinsic_body(line, CLAMPED, n)) for n in (2, None))
    for station in line.tree.ends:
        assert cantilever_frequency(few, station) == pytest.approx(
            cantilever_frequency(every, station), rel=2e-2
        )


def test_a_released_body_keeps_its_damping_and_name():
    damping = ModalDamping(0.02)
    made = intrinsic_body(beam_line(straight(1.0, 8), **SLENDER), CLAMPED, 3)
    free = released(replace(made, damping=damping))
    assert free.damping is damping
    assert free.name == made.name


def cantilever_frequency(body, station):
    """Lowest frequency of small motions with one station held."""
    modes = body.modes
    moving = linalg.null_space(modes.velocities[station], rcond=1e-9)
    return np.sqrt(np.linalg.eigvalsh(moving.T * modes.omega**2 @ moving)[0])


def test_all_modes_need_no_others(whole):
    assert whole.truncated(whole.n_coordinates) is whole
    with pytest.raises(ModelError, match="121 elastic modes requested: request 1 to 120"):
        whole.truncated(121)

"""Joint loads and the numbers of a run, from a solution made up of known joint forces."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_lines import beam_line, straight

from supple.machine import GROUND, At, Placed, Revolute, System
from supple.methods.intrinsic import CLAMPED, FREE, intrinsic_body
from supple.quantities import joint_loads, tracked_motion
from supple.results import summarize
from supple.results.run_summary import body_numbers
from supple.results.run_tables import body_table


@pytest.fixture
def hinged(rod, make):
    """A rod on a hinge, and three instants at which the hinge's forces are known."""
    hinge = Revolute(name="hinge", first=GROUND, second=At("rod", "left"), axis=(0.0, 1.0, 0.0))
    made = make(n_times=3)
    forces = np.zeros((3, 6))
    forces[1], forces[2] = [3.0, 0.0, -4.0, 0.0, -12.0, 0.0], [-1.0, -2.0, -2.0, 5.0, 0.0, 0.0]
    solution = type(made)(made.times, {"rod": made.bodies["hub"]}, {"hinge": forces}, made.statistics)
    return System(bodies=(Placed(rod("rod", 2.0)),), joints=(hinge,)), solution


def test_the_loads_of_a_joint_are_the_components_of_the_solution_by_kind(hinged):
    loads = joint_loads(*hinged)["hinge"]
    np.testing.assert_array_equal(loads["force"][1:], [[3.0, 0.0, -4.0], [-1.0, -2.0, -2.0]])
    np.testing.assert_array_equal(loads["moment"][1:], [[0.0, -12.0, 0.0], [5.0, 0.0, 0.0]])


def test_the_summary_finds_the_largest_values_and_their_times(hinged):
    system, solution = hinged
    place = tracked_motion(system.bodies[0].body, solution.bodies["rod"], "right")
    numbers = summarize(system, solution, {"rod.right": place})
    joint = numbers["joints"]["hinge"]
    assert (joint["largest force"], joint["time of largest force"]) == (5.0, solution.times[1])
    assert joint["acts on"] == "rod.left"
    assert joint["axes"].startswith("joint axes that rotate with the first end")
    assert (joint["largest moment"], joint["time of largest moment"]) == (12.0, solution.times[1])
    np.testing.assert_array_equal(joint["last force"], [-1.0, -2.0, -2.0])
    assert numbers["bodies"]["rod"] == {"kind": "rigid", "mass": 1.0}
    np.testing.assert_array_equal(numbers["tracked"]["rod.right"]["last position"], place.position[-1])
    assert numbers["statistics"]["cuts"] == solution.statistics.rejected_steps


@pytest.mark.parametrize(
    ("support", "place", "factor"), [(CLAMPED, "root", 3.516), (FREE, "floating frame", 22.373)]
)
def test_frequencies_of_an_intrinsic_body_name_its_support(support, place, factor):
    """The first frequency of a uniform beam is factor / 2 pi sqrt(E I / m) / L^2, clamped and free."""
    line = beam_line(
        straight(1.0, 30), name="line", EA=1e6, EI=14.0, GJ=10.0, mass_per_length=1.5, radius=0.01
    )
    numbers = body_numbers(intrinsic_body(line, support, 12))
    (row,) = body_table({"units": {}, "bodies": {"line": numbers}}).rows
    assert row[6] == place
    first = float(row[7].split()[0])
    assert first == pytest.approx(factor / (2 * np.pi) * (14.0 / 1.5) ** 0.5, rel=0.02)

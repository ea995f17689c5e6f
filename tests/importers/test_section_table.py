"""Section tables: what is rejected as no section, and what lies between sections."""

import re

import numpy as np
import pytest
from fixtures.section_tables import COUPLED, OFFSET, helix, helix_table, inertia, prismatic

from supple.errors import ModelError
from supple.importers import SectionTable, section_matrix, twisted_axes


def changed(matrix, i, j, value):
    """With one number of both triangles changed."""
    new = matrix.copy()
    new[i - 1, j - 1] = new[j - 1, i - 1] = value
    return new


def test_between_sections_all_is_linear_and_axes_turn_evenly():
    table = helix_table(41)
    positions, axes, stiffness, mass = table.at([0.0, 1.0, 2.345, table.lengths[-1]])
    assert positions[0] == pytest.approx(table.positions[0])
    assert positions[-1] == pytest.approx(table.positions[-1])
    exact = [helix(s)[1] for s in (0.0, 1.0, 2.345, 4.0)]
    assert axes == pytest.approx(np.array([each.axes for each in exact]), abs=2e-3)
    assert stiffness == pytest.approx(np.array([each.stiffness for each in exact]), rel=1e-3)
    assert mass == pytest.approx(np.array([each.inertia for each in exact]), rel=1e-3)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_an_upper_triangle_is_read_row_by_row():
    matrix = section_matrix(np.arange(1, 22))
    assert matrix[0].tolist() == [1, 2, 3, 4, 5, 6]
    assert matrix[:, 5].tolist() == [6, 11, 15, 18, 20, 21]
    assert (matrix == matrix.T).all()


def test_twist_turns_x_towards_minus_y():
    """About -z: a positive twist at the root turns the suction side away from the trailing edge."""
    straight = twisted_axes([[0, 0, 2.0]], np.array([0.3]))[0]
    assert straight[:, 0] == pytest.approx([np.cos(0.3), -np.sin(0.3), 0])
    bent = twisted_axes([[-0.3, 0.1, 1.0]], np.array([0.0]))[0]
    assert bent[1, 0] == pytest.approx(0, abs=1e-15)
    assert bent[0, 0] > 0.9
    assert bent.T @ bent == pytest.approx(np.eye(3))
    assert bent[:, 2] == pytest.approx(np.array([-0.3, 0.1, 1.0]) / np.sqrt(1.1))


VABS = [2, 0, 1, 5, 3, 4]
"""Axes in another order: along the beam first."""


@pytest.mark.parametrize(
    ("stiffness", "mass", "message"),
    [
        (changed(COUPLED, 4, 4, -1.0), OFFSET, "section 0: stiffness 44 is -1; it must be positive"),
        (changed(COUPLED, 4, 6, 1e5), OFFSET, "section 0: its stiffness is not positive definite"),
        (COUPLED + np.eye(6, k=1), OFFSET, "stiffness is not symmetric: 12 is 1 and 21 is 0"),
        (COUPLED, changed(OFFSET, 3, 3, 0.0), "section 0: inertia 33 is 0; it must be positive"),
        (COUPLED, changed(OFFSET, 2, 2, 4.0), "its mass differs with the direction"),
        (COUPLED, changed(OFFSET, 1, 6, -0.06), "its first moments are not of a mass in its plane"),
        (COUPLED, changed(OFFSET, 1, 5, 0.1), "its first moments are not of a mass in its plane"),
        (COUPLED, inertia(3.0, 0.3, 0.2, -0.1, 0.05), "less than mass times squared distance"),
        (COUPLED, OFFSET[np.ix_(VABS, VABS)], "its first moments are not of a mass in its plane"),
        (
            COUPLED,
            inertia(3.0, 0, 0, 0.02, 0.05)[np.ix_(VABS, VABS)],
            "its polar moment of inertia, 66, is less than 44 or 55",
        ),
    ],
)
def test_what_is_no_section_is_refused(stiffness, mass, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        prismatic(stiffness=stiffness, mass=mass)


def test_digits_of_a_table_are_no_mistake():
    """Of seven digits; of moments of inertia of a thin plate; of a section without it in bending."""
    rounded = np.vectorize(lambda x: float(f"{x:.7g}"))
    prismatic(stiffness=rounded(COUPLED), mass=rounded(OFFSET / 3))
    prismatic(mass=inertia(3.0, 0, 0, 0.0, 0.05))
    prismatic(mass=changed(changed(inertia(3.0, 0, 0, 0.1, 0.1), 4, 4, 0.0), 5, 5, 0.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": np.zeros((3, 3))}, "sections 0 and 1 are at the same position"),
        ({"axes": np.tile(2 * np.eye(3), (3, 1, 1))}, "section 0: its axes are no rotation"),
        ({"axes": np.tile(np.diag([1, -1, 1.0]), (3, 1, 1))}, "section 0: its axes are no rotation"),
        ({"axes": np.tile(np.diag([1, -1, -1.0]), (3, 1, 1))}, "is at 180 degrees from its axis z"),
        ({"stiffness": np.zeros((2, 6, 6))}, "stiffness have shape (2, 6, 6)"),
        ({"positions": np.full((3, 3), np.nan)}, "finite numbers"),
    ],
)
def test_a_curve_that_is_none_is_refused(change, message):
    plain = prismatic(n=3)
    parts = {name: getattr(plain, name) for name in ("positions", "axes", "stiffness", "inertia")}
    with pytest.raises(ModelError, match=re.escape(message)):
        SectionTable(**(parts | change))

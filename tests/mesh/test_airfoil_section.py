"""Airfoil section against closed forms of a circle and a wedge, and its error messages."""

import numpy as np
import pytest

from supple.errors import MeshError
from supple.mesh import AirfoilSection, TrailingEdge

DIAMOND = np.array([[1, 0], [0.5, -0.1], [0, 0], [0.5, 0.1], [1, 0]])


def circle(n):
    angle = np.linspace(0, 2 * np.pi, 2 * n + 1)
    return np.column_stack([(1 + np.cos(angle)) / 2, np.sin(angle) / 2])


def test_a_circle_keeps_its_shape():
    section = AirfoilSection("circle", circle(2000), TrailingEdge.ROUND)
    x = np.linspace(0.01, 0.99, 50)
    np.testing.assert_allclose(section.heights(x), [-np.sqrt(x * (1 - x)), np.sqrt(x * (1 - x))], atol=1e-5)


def test_either_side_may_come_first():
    x = np.linspace(0, 1, 11)
    one, other = AirfoilSection("a", DIAMOND), AirfoilSection("b", DIAMOND[::-1])
    np.testing.assert_array_equal(one.heights(x), other.heights(x))
    assert (one.heights(x)[0] <= one.heights(x)[1]).all()


def test_a_blunt_base_closes_over_the_last_tenth():
    """Sides at y = +-0.1 x, base 0.2 high: unchanged to x = 0.9, then linear to the middle of the base."""
    wedge = AirfoilSection(
        "wedge", np.array([[1, 0], [1, -0.1], [0.5, -0.05], [0, 0], [0.5, 0.05], [1, 0.1]])
    )
    x = np.array([0.3, 0.9, 0.95, 1.0])
    np.testing.assert_allclose(wedge.heights(x)[1], [0.03, 0.09, 0.095 - 0.05, 0.0], atol=1e-15)
    np.testing.assert_allclose(wedge.heights(x).sum(axis=0), 0, atol=1e-15)


def test_a_side_that_ends_early_goes_on_at_its_height():
    outline = np.array([[1, 0], [0.5, -0.1], [0, 0], [0.5, 0.1], [0.8, 0.02]])
    x = np.array([0.85, 1.0])
    np.testing.assert_allclose(AirfoilSection("open", outline).heights(x)[1], [0.02, 0.01], atol=1e-15)


def test_outline_is_a_private_copy():
    outline = DIAMOND.copy()
    section = AirfoilSection("diamond", outline)
    outline[1, 1] = 7.0
    assert section.outline[1, 1] == -0.1
    with pytest.raises(ValueError, match="read-only"):
        section.outline[0, 0] = 2.0


@pytest.mark.parametrize(
    ("outline", "message"),
    [
        (DIAMOND.ravel(), "shape"),
        (DIAMOND[:4], "too few points \\(4\\)"),
        (np.where(DIAMOND == 0.1, np.nan, DIAMOND), "point 3 is"),
        (300 * DIAMOND, "divide it by its chord"),
        (
            np.array([[1, 0], [0.4, -0.08], [0.6, -0.15], [0, 0], [0.5, 0.1], [1, 0]]),
            r"folds back .* \(0\.6, -0\.15\)",
        ),
        (
            np.array([[1, 0], [0.7, -0.1], [0.3, 0.1], [0, 0], [0.3, -0.1], [0.7, 0.1], [1, 0]]),
            r"crosses itself between x/c = 0\.3 and 0\.7",
        ),
        (np.array([[0, 0], [0.5, 0.1], [0.7, 0.1], [0.9, 0], [1, 0]]), "folds back"),
    ],
)
def test_errors(outline, message):
    with pytest.raises(MeshError, match=f"section 'bad': .*{message}"):
        AirfoilSection("bad", outline)

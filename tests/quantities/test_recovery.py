"""Displacements as seen from moving axes, and the errors measured on the motion of nodes."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.body import floating_kinematics, floating_positions
from supple.errors import ModelError
from supple.quantities import displacement_from_axes, node_positions
from supple.results import motion_error, relative_error, rms_error


@dataclass(frozen=True)
class Strip:
    """Nodes with a displacement basis (N, 3, r)."""

    nodes: np.ndarray
    basis: np.ndarray
    positions = floating_positions

    def expand(self, gamma, nodes=slice(None)):
        return np.einsum("kir,...r->...ki", self.basis[nodes], gamma)


BEAM = "beam/left 100%"


@pytest.fixture
def strip():
    rng = np.random.default_rng(4)
    return Strip(rng.normal(size=(6, 3)), rng.normal(size=(6, 3, 5)))


def test_a_point_at_rest_in_moving_axes_shows_no_displacement():
    rng = np.random.default_rng(0)
    axes, origin, rest = (
        Rotation.random(4, rng=rng).as_matrix(),
        rng.normal(size=(4, 3)),
        np.array([0.0, 10.0, 0.0]),
    )
    moved = np.array([0.1, -0.2, -0.5])
    positions = origin + axes @ (rest + moved)
    seen = displacement_from_axes(positions, origin, axes, rest)
    np.testing.assert_allclose(seen, np.tile(moved, (4, 1)), atol=1e-13)


def test_rms_of_a_uniform_offset_is_its_length():
    r = np.random.default_rng(1).normal(size=(3, 8, 3))
    np.testing.assert_allclose(rms_error(r, r + np.array([3.0, 0.0, 4.0])), 5.0, rtol=1e-13)


def test_relative_error_of_a_scaled_motion_is_the_scale():
    r = np.random.default_rng(1).normal(size=(3, 8, 3))
    assert relative_error(r, 1.02 * r) == pytest.approx(2.0, rel=1e-12)


def test_errors_of_solutions_are_those_of_their_positions(strip, make, monkeypatch):
    one, other = make(seed=1), make(seed=2)
    monkeypatch.setattr(floating_kinematics, "_FIELD_NUMBERS", 3 * strip.nodes.size)
    error = motion_error(one, strip, other, strip, body=BEAM)
    r, rbar = node_positions(strip, one.bodies[BEAM]), node_positions(strip, other.bodies[BEAM])
    np.testing.assert_allclose(error.rms, rms_error(r, rbar), rtol=1e-13)
    assert error.relative_percent == pytest.approx(relative_error(r, rbar), rel=1e-12)
    assert error.max_rms == error.rms.max()


def test_only_like_is_compared_with_like(strip, make, solution):
    r = np.zeros((2, 3, 3))
    with pytest.raises(ModelError, match=r"shapes \(2, 3, 3\) and \(2, 4, 3\)"):
        rms_error(r, np.zeros((2, 4, 3)))
    with pytest.raises(ModelError, match="no body 'wing' in the solution; it has beam/left 100%, hub"):
        motion_error(solution, strip, solution, strip, body="wing")
    with pytest.raises(ModelError, match="different output times"):
        motion_error(solution, strip, make(n_times=6), strip, body=BEAM)
    with pytest.raises(ModelError, match=r"different nodes \(6 and 6\)"):
        motion_error(solution, strip, solution, replace(strip, nodes=strip.nodes + 1.0), body=BEAM)

"""Made-up solutions of the right shapes."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from supple.integrate.solution import BodyMotion, Solution, Statistics


def _motion(rng, n_times, r):
    return BodyMotion(
        position=rng.normal(size=(n_times, 3)),
        rotation=Rotation.random(n_times, rng=rng).as_matrix(),
        coordinates=rng.normal(size=(n_times, r)),
        velocity=rng.normal(size=(n_times, 3)),
        angular_velocity=rng.normal(size=(n_times, 3)),
        coordinate_rates=rng.normal(size=(n_times, r)),
        acceleration=rng.normal(size=(n_times, 3)),
        angular_acceleration=rng.normal(size=(n_times, 3)),
        coordinate_accelerations=rng.normal(size=(n_times, r)),
    )


def make_solution(start=0.0, n_times=7, seed=0):
    """A beam with five coordinates, a rigid hub, a ball joint and a joint that constrains nothing."""
    rng = np.random.default_rng(seed)
    return Solution(
        times=start + 0.1 * np.arange(n_times),
        bodies={"beam/left 100%": _motion(rng, n_times, 5), "hub": _motion(rng, n_times, 0)},
        joint_forces={"ball": rng.normal(size=(n_times, 3)), "free": np.empty((n_times, 0))},
        statistics=Statistics(
            steps=n_times, iterations=2 * n_times, cuts=1, seconds=0.25, compile_seconds=0.5
        ),
    )


@pytest.fixture
def solution():
    return make_solution()


@pytest.fixture
def make():
    return make_solution

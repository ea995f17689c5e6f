"""Bodies and small systems shared by the tests. Every compiled system costs seconds: share them."""

from __future__ import annotations

import os

import numpy as np
import pytest

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidBody, RigidInterface, flexible_body
from supple.fem import HomogeneousWall, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, NormalModes, reduce

# The systems here are small and run for moments: compile them quickly rather than well.
os.environ.setdefault("XLA_FLAGS", "--xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false")


def pytest_configure(config):
    """Keep compiled systems between runs, where pytest keeps what it knows about the last one."""
    import jax

    jax.config.update("jax_compilation_cache_dir", str(config.cache.mkdir("jax")))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)


def _turned(axis, angle):
    """Rotation matrix about a coordinate axis (0, 1, 2)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[[i, j], [i, j]] = cosine
    matrix[i, j], matrix[j, i] = -sine, sine
    return matrix


@pytest.fixture(scope="session")
def turned():
    return _turned


def _rod(name, length, mass=1.0):
    """A slender rod along x, frame at its centre, interfaces at its ends."""
    inertia = np.diag([1e-3, 1.0, 1.0]) * mass * length**2 / 12
    return RigidBody(
        name, mass, np.zeros(3), inertia, {"left": [-length / 2, 0, 0], "right": [length / 2, 0, 0]}
    )


@pytest.fixture(scope="session")
def rod():
    return _rod


@pytest.fixture(scope="session")
def blade():
    """A flat elastic strip along x, 1 m long, held at neither end."""
    wall = HomogeneousWall(Isotropic(1e7, 0.3, 1000.0), 0.02)
    model = shell_model(strip(1.0, 0.1, 6, 2), wall)
    return flexible_body("blade", model, (RigidInterface("root", "root"), RigidInterface("tip", "tip")))


@pytest.fixture(scope="session")
def floating_blade(blade):
    """The strip in its mean axes: three modes and three derivatives, geometrically nonlinear."""
    return reduce(blade, MeanAxisFrame(), NormalModes(3), derivatives=CompressedDerivatives(3))


@pytest.fixture(scope="session")
def clamped_blade(blade):
    """The strip seen from its root: three modes and three derivatives, geometrically nonlinear."""
    return reduce(blade, NodalFixedFrame("root"), NormalModes(3), derivatives=CompressedDerivatives(3))

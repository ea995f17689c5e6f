"""A small solid body, reduced with and without its quadratic strains."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from supple.body import AveragingInterface, MeanAxisFrame, NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, block
from supple.reduction import CompressedDerivatives, CraigBampton, NoDerivatives, Rubin, reduce

STEEL = Isotropic(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7800.0)


@pytest.fixture(scope="session")
def model():
    return solid_model(block(1.0, 0.2, 0.1, 4, 1, 1, CellType.TETRA10), STEEL)


@pytest.fixture(scope="session")
def flexible(model):
    ends = [RigidInterface("root", "root"), AveragingInterface("far tip/µ", "tip")]
    return flexible_body("blade/left 100 %", model, ends)


@pytest.fixture(scope="session")
def nonlinear(flexible):
    return reduce(
        flexible, NodalFixedFrame("root"), CraigBampton(n_modes=4), derivatives=CompressedDerivatives(3)
    )


@pytest.fixture(scope="session")
def linear(flexible):
    return reduce(flexible.linearized(), MeanAxisFrame(), Rubin(n_modes=3), derivatives=NoDerivatives())


def _assert_same(one, other):
    """Equal in type, shape and every bit, through all fields of records."""
    assert type(one) is type(other) or isinstance(one, dict)
    if is_dataclass(one):
        for item in fields(one):
            _assert_same(getattr(one, item.name), getattr(other, item.name))
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        assert one.shape == other.shape
        assert one.tobytes() == other.tobytes()
    elif isinstance(one, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            _assert_same(a, b)
    else:
        assert one == other


@pytest.fixture(scope="session")
def assert_same():
    return _assert_same

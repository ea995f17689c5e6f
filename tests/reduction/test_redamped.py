"""A body that is reduced already has another damping as if it had been reduced with it."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import (
    LinearRayleighDamping,
    MeanAxisFrame,
    ModalDamping,
    RayleighDamping,
    RigidInterface,
    flexible_body,
)
from supple.errors import ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip
from supple.reduction import CompressedDerivatives, CraigBampton, redamped, reduce


@pytest.fixture(scope="module")
def body():
    """A steel strip with an interface at either end."""
    mesh = strip(1.0, 0.1, 8, 2)
    model = shell_model(mesh, HomogeneousSection(Isotropic(2.1e11, 0.3, 7850.0), 0.01))
    return flexible_body("strip", model, [RigidInterface("root", "root"), RigidInterface("tip", "tip")])


def reduced(body, damping):
    return reduce(
        body, MeanAxisFrame(), CraigBampton(3), derivatives=CompressedDerivatives(2), damping=damping
    )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (RayleighDamping(1.5, 2e-3), RayleighDamping(0.2, 7e-4)),
        (LinearRayleighDamping(1.5, 2e-3, "tip"), LinearRayleighDamping(4.0, 0.0, "tip")),
        (ModalDamping(0.02, held="root"), ModalDamping(0.05, held="root")),
        (RayleighDamping(1.5, 2e-3, "root"), RayleighDamping(0.0, 0.0, "root")),
    ],
)
def test_damping_is_that_of_a_reduction_anew(body, before, after):
    found, expected = redamped(reduced(body, before), before, after), reduced(body, after)
    size = np.abs(reduced(body, before).damping).max()
    # Modes of a pencil are found to fewer digits than matrices are added.
    digits = 1e-10 if isinstance(before, ModalDamping) else 1e-12
    assert np.abs(found.damping - expected.damping).max() < digits * size
    for name in ("damping_cubic", "damping_quartic"):
        own, other = getattr(found, name), getattr(expected, name)
        other = 0.0 * own if other is None and own is not None else other
        assert own is other is None or np.abs(own - other).max() <= 1e-14 * np.abs(own).max()
    assert np.array_equal(found.gram, expected.gram)
    assert found.full is not None
    assert repr(found.full.damping) == repr(expected.full.damping)


def test_another_kind_of_damping_is_refused(body):
    held = RayleighDamping(1.0, 1e-3, "root")
    with pytest.raises(ModelError, match="another kind of damping"):
        redamped(reduced(body, held), held, LinearRayleighDamping(1.0, 1e-3, "root"))
    with pytest.raises(ModelError, match="another kind of damping"):
        redamped(reduced(body, held), held, RayleighDamping(1.0, 1e-3))
    undamped = RayleighDamping(1.0, 0.0)
    with pytest.raises(ModelError, match="reduce it with beta > 0"):
        redamped(reduced(body, undamped), undamped, RayleighDamping(1.0, 1e-3))

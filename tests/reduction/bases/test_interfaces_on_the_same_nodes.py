"""A second interface on the nodes of another one moves with it: the bases are those without it."""

import numpy as np
import pytest

from supple.body import AveragingInterface, MeanAxisFrame, RigidInterface, flexible_body
from supple.body.averaging_error import section_softness
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, block
from supple.reduction import (
    CompressedDerivatives,
    CouplingMoment,
    CraigBampton,
    CraigBamptonResidual,
    EffectiveInterfaceMass,
    ErrorControlled,
    Guyan,
    Herting,
    Rubin,
    reduce,
)

TIP, ROOT = AveragingInterface("tip", "tip"), RigidInterface("root", "root")


def bar(*interfaces):
    model = solid_model(block(1.0, 0.1, 0.1, 4, 1, 1, CellType.HEXA8), Isotropic(7e10, 0.3, 2700.0))
    return flexible_body("bar", model, interfaces)


@pytest.fixture(scope="module")
def bodies():
    """With a marker ahead of the tip on the nodes of the tip, and without."""
    return bar(TIP, AveragingInterface("marker", "tip", position=(1.2, 0, 0)), ROOT), bar(TIP, ROOT)


@pytest.mark.parametrize(
    "basis",
    [
        CraigBampton(3),
        CraigBampton(3, selection=CouplingMoment(6)),
        CraigBampton(3, selection=EffectiveInterfaceMass(6)),
        CraigBamptonResidual(2),
        Herting(3),
        Rubin(n_columns=12),
        Guyan(),
        # Its four modes lack the static shapes of the interfaces.
        pytest.param(ErrorControlled(1e-2, 4), marks=pytest.mark.filterwarnings("ignore:.*locks")),
    ],
    ids=lambda basis: type(basis).__name__,
)
def test_the_basis_is_that_without_the_second_interface(bodies, basis):
    two, one = (reduce(body, MeanAxisFrame(), basis, derivatives=CompressedDerivatives(2)) for body in bodies)
    np.testing.assert_allclose(two.frequencies, one.frequencies, rtol=1e-6)
    tip, marker = (two.interface(name).motion for name in ("tip", "marker"))
    np.testing.assert_allclose(marker[1], tip[1] + 0.2 * tip[5], atol=1e-10 * np.abs(tip).max())


def test_moments_on_an_averaging_interface_are_not_taken_by_its_double(bodies):
    two, one = (section_softness(body, body.interface("tip")) for body in bodies)
    np.testing.assert_allclose(two, one, rtol=1e-8)


def test_means_that_depend_on_each_other_in_part_are_named():
    """Three nodes have nine freedoms, two means twelve."""
    nodes = bar(TIP, ROOT).model.mesh.nodes_of("tip")[:3]
    means = (
        AveragingInterface(name, nodes, weights=own)
        for name, own in zip("ab", ([1, 1, 1], [1, 2, 3]), strict=True)
    )
    with pytest.raises(ModelError, match="interfaces 'a' and 'b' depend on each other: keep one"):
        reduce(bar(*means), MeanAxisFrame(), CraigBampton(2))

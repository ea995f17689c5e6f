"""A solid with rotating and averaging interfaces, reduced in three ways to the same superelement."""

import pytest

from supple.body import MeanAxisFrame, RayleighDamping
from supple.export import interface_form
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce


@pytest.fixture(scope="session")
def craig_bampton(flexible):
    return reduce(
        flexible.linearized(),
        MeanAxisFrame(),
        CraigBampton(n_modes=5),
        derivatives=NoDerivatives(),
        loads=NoLoads,
        damping=RayleighDamping(0.0, 1e-5),
    )


@pytest.fixture(scope="session")
def form(craig_bampton):
    return interface_form(craig_bampton)

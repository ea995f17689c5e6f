"""What bases cost in the modes of a Campbell diagram, speed by speed, beside the diagram of the full body."""

from __future__ import annotations

import pytest

from supple.body import FullBody, MeanAxisFrame, RigidInterface, flexible_body
from supple.errors import BasisWarning
from supple.fem import Isotropic, solid_model
from supple.linearization import campbell_diagram
from supple.machine import GROUND, At, PrescribedRotation, Spin, System
from supple.mesh import CellType, block
from supple.reduction import CraigBampton, NoDerivatives, NoLoads, reduce

SPINS = [Spin(rate, (0, 0, 1)) for rate in (0.0, 5.0, 20.0, 10.0)]


@pytest.fixture(scope="module")
def bar():
    model = solid_model(block(1.0, 0.02, 0.01, 4, 1, 1, CellType.HEXA20), Isotropic(1e9, 0.0, 1000.0))
    return flexible_body("bar", model, (RigidInterface("root", "root"),))


def turned(form):
    hub = PrescribedRotation(name="hub", first=GROUND, second=At("bar", "root"), axis=(0, 0, 1), angle=0.0)
    return System((form,), (hub,))


@pytest.mark.slow
def test_every_speed_states_its_error_and_the_worst_is_warned_of(bar):
    """Without the axial shape that a spin stretches nothing stiffens: wrong the more the faster it turns."""
    reduced = reduce(bar, MeanAxisFrame(), CraigBampton(4), derivatives=NoDerivatives(), loads=NoLoads)
    worst = "at 3 of 4 speeds, most at 20 rad per unit of time: "
    with (
        pytest.warns(BasisWarning, match=f"{worst}body 'bar': at rest a node is off by"),
        pytest.warns(BasisWarning, match=f"{worst}the bases of the bodies: mode 1 is off by"),
    ):
        diagram = campbell_diagram(turned(reduced), SPINS, n_modes=2)
    exact = campbell_diagram(turned(FullBody(bar, MeanAxisFrame())), SPINS, n_modes=2)
    apart = abs(diagram.eigenvalues - exact.eigenvalues) / abs(exact.eigenvalues)
    assert diagram.errors == pytest.approx(apart, rel=1e-5, abs=1e-9)
    assert diagram.errors[2, 0] > 0.05
    assert exact.errors is None


def test_errors_are_left_out_where_no_full_body_is_asked_for(bar):
    reduced = reduce(bar, MeanAxisFrame(), CraigBampton(4), derivatives=NoDerivatives(), loads=NoLoads)
    slow = [Spin(rate, (0, 0, 1)) for rate in (0.0, 4.0)]
    assert campbell_diagram(turned(reduced), slow, n_modes=2, fulls=()).errors is None

"""Modal parts are watched: their stress against the yield stress, their rotation, their spin."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar, explicit_bar

from supple.body import LinearRayleighDamping, flexible_body
from supple.errors import ModelError, ValidityError, ValidityWarning
from supple.integrate import Run, Validity
from supple.machine import (
    DeadForce,
    Placed,
    System,
)
from supple.mesh import CellType
from supple.methods.explicit import (
    J2Plasticity,
    LinearHardening,
    explicit_subdomain,
    modal_subdomain,
)
from supple.quantities import largest_stress
from supple.reduction import NormalModes
from supple.simulation import simulate

LENGTH, SPIN = 4.0, 0.3
STRESS = SOFT.density * SPIN**2 * LENGTH**2 / 8
"""Of a bar that spins about its middle, there: rho Omega^2 L^2 / 8."""
RUN = Run(20.0, 2.0)


def spinning(spin=SPIN, **options):
    """Damped, so that it soon pulls as it spins."""
    body = flexible_body("rotor", bar(CellType.HEXA8, (12, 1, 1)))
    damping = LinearRayleighDamping(2.0, 0.0)
    own = modal_subdomain(body, NormalModes(30), damping=damping, **options)
    return Placed(own, angular_velocity=(0.0, 0.0, spin), velocity=(0.0, -spin * LENGTH / 2, 0.0))


def test_damping_against_an_interface_is_of_floating_frames_alone():
    body = flexible_body("rotor", bar(CellType.HEXA8, (4, 1, 1)))
    with pytest.raises(ModelError, match="'rotor': its damping is relative to the interface"):
        modal_subdomain(body, NormalModes(3), damping=LinearRayleighDamping(1.0, 0.0, held="root"))
    with pytest.raises(ModelError, match="'bar': its damping is relative to the interface"):
        explicit_subdomain(body.model, name="bar", damping=LinearRayleighDamping(1.0, 0.0, held="root"))


def heard(system, run=RUN):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        simulate(system, run)
    return [str(each.message) for each in found if issubclass(each.category, ValidityWarning)]


@pytest.mark.slow
def test_stress_beyond_the_yield_stress_is_said_with_its_place():
    (said,) = heard(System([spinning(yield_stress=0.8 * STRESS)]))
    stress = float(re.search(r"von Mises stress of (\S+) at node (\d+)", said).group(1))
    node = int(re.search(r"at node (\d+)", said).group(1))
    # The first swing goes beyond the pull that remains, at most to twice of it.
    assert STRESS < stress < 2 * STRESS
    assert bar(CellType.HEXA8, (12, 1, 1)).mesh.nodes[node, 0] == pytest.approx(LENGTH / 2, abs=0.4)
    assert f"above its yield stress {0.8 * STRESS:.4g}" in said
    assert not heard(System([spinning(yield_stress=2 * STRESS)]))
    part = spinning()
    solution = simulate(System([part]), RUN)
    model = part.body.body.model
    found = largest_stress(part.body, model, solution.bodies["rotor"].coordinates)
    assert (int(model.mesh.node_ids[found.node]), found.value) == (node, pytest.approx(stress, rel=1e-3))


@pytest.mark.slow
def test_a_part_without_a_yield_stress_has_that_of_its_metal():
    law = J2Plasticity(SOFT, LinearHardening(0.8 * STRESS))
    beside = Placed(explicit_bar(CellType.HEXA8, law, (2, 1, 1)), position=(0.0, 5.0, 0.0))
    short = Run(6.0, 2.0)
    (said,) = heard(System([spinning(), beside]), short)
    assert f"above the yield stress of 'bar', of the same material, {0.8 * STRESS:.4g}" in said
    assert not heard(System([spinning(yield_stress=np.inf), beside]), short)


def test_a_strict_run_ends_where_a_limit_is_passed():
    system = System([spinning(yield_stress=0.5 * STRESS)])
    with pytest.raises(ValidityError, match="it would yield there"):
        simulate(system, Run(20.0, 2.0, validity=Validity(strict=True)))


def test_a_spin_too_fast_for_modes_at_rest_is_said():
    run = Run(0.2, 0.1)
    first = spinning().body.frequencies[0]
    (said,) = heard(System([spinning(0.35 * first)]), run)
    assert "0.35 times its lowest frequency" in said
    assert not heard(System([spinning(0.25 * first)]), run)


@pytest.mark.slow
def test_a_bar_that_bends_far_is_said():
    """Ends that are pushed while the middle lags: the slope there is the angle that is said."""
    part = spinning(0.0).body
    push = [DeadForce(at=f"rotor.{end}", force=(0.0, 0.0, 1.5)) for end in ("root", "tip")]
    with pytest.warns(ValidityWarning, match="rad relative to its frame") as said:
        solution = simulate(System([part], loads=push), Run(2.0, 0.1))
    angle = float(re.search(r"rotates by (\S+) rad", str(said[0].message)).group(1))
    x, z = part.body.nodes[:, 0], part.positions(solution.bodies["rotor"])[:, :, 2]
    inner, end = (z[:, np.isclose(x, at)].mean(axis=1) for at in (LENGTH * 11 / 12, LENGTH))
    assert angle == pytest.approx(np.abs(end - inner).max() / (LENGTH / 12), rel=0.05)


def test_a_yield_stress_is_positive():
    with pytest.raises(ModelError, match="yield stress of part 'rotor' must be positive"):
        spinning(yield_stress=0.0)
    part = spinning().body
    matrices = replace(part.body, model=None)
    with pytest.raises(ModelError, match="'rotor' has no elements, only matrices, so its stress is unknown"):
        replace(part, body=matrices, yield_stress=1.0)

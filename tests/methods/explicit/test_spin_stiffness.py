"""Stiffness of modal sub-domains under spin: definition, a closed form, the floating frame, the balance."""

import numpy as np
import pytest
from fixtures.explicit_bars import stepped
from fixtures.frame_momentum import half_steps
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from supple.body import MeanAxisFrame, flexible_body
from supple.errors import ModelError
from supple.fem import Isotropic, solid_model
from supple.integrate import Run, run
from supple.linearization import linearize, machine_modes
from supple.machine import (
    DeadForce,
    Placed,
    Spin,
    System,
)
from supple.mesh import CellType, block
from supple.methods.explicit import (
    ENERGIES,
    CentrifugalStiffness,
    ExplicitEngine,
    PublishedScheme,
    modal_subdomain,
)
from supple.methods.explicit.frame_model import FrameState
from supple.methods.explicit.spin_stiffness import PAIRS, largest_of_unit_spin
from supple.reduction import CompressedDerivatives, NoLoads, NormalModes, reduce
from supple_benchmarks.explicit.free_flight import angular_momentum

AROUND = np.array([0.97, 1.2])
"""Where the frequencies of bending are under the spin, relative to those at rest."""


@pytest.fixture(scope="module")
def body():
    model = solid_model(block(8, 1, 1, 8, 2, 2, CellType.HEXA8), Isotropic(100.0, 0.3, 1.0))
    return flexible_body("rotor", model)


@pytest.fixture(scope="module")
def rotor(body):
    return modal_subdomain(body, NormalModes(8), stiffening=CentrifugalStiffness())


def spun(matrices, spin):
    return np.einsum("p,pkl->kl", [spin[a] * spin[b] for a, b in PAIRS], matrices)


def test_it_is_the_change_of_the_tangent_under_the_inertia_forces_of_the_spin(body, rotor):
    spin = np.array([0.3, -0.5, 0.8])
    X = body.nodes - rotor.points.origin
    force = body.nodal_mass @ -np.cross(spin, np.cross(spin, X)).ravel()
    R, M = body.rigid_modes, body.mass
    force = force - M @ (R @ np.linalg.solve(R.T @ M @ R, R.T @ force))
    u = body.constrained((M @ R).T).solve(force)
    assert np.abs(R.T @ force).max() < 1e-12
    # The tangent is a polynomial of second degree: a central difference is exact.
    change = 0.5 * (body.assembly.tangent(u) - body.assembly.tangent(-u))
    expected = rotor.vectors.T @ (change @ rotor.vectors)
    found = spun(rotor.spin_stiffness, spin)
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()


def test_a_slender_rotor_stiffens_as_a_string_under_its_tension(body, rotor):
    """K = int T w'^2 dx, T = rho A Omega^2 (L^2 / 4 - s^2) / 2, of a beam that spins across its middle."""
    middle = (np.abs(body.nodes[:, 1]) < 1e-9) & (np.abs(body.nodes[:, 2]) < 1e-9)
    order = np.flatnonzero(middle)[np.argsort(body.nodes[middle, 0])]
    x = np.linspace(0, 8, 400)
    tension = 0.5 * (16 - (x - 4) ** 2)
    for mode in (0, 1, 3):
        w = rotor.shapes[order][:, 1:, mode] * rotor.points.arm
        slope = CubicSpline(body.nodes[order, 0], w)(x, 1)
        string = np.trapezoid(tension * (slope**2).sum(axis=1), x)
        assert rotor.spin_stiffness[2, mode, mode] == pytest.approx(
            string, rel=0.04
        )  # an eighth as thick as long


def flapped(part, rate, span=24.0, n=96):
    """A rotor that spins about z and is pushed along z at its ends, which bends it out of its plane."""
    pushes = [DeadForce(at=f"rotor.{end}", force=(0.0, 0.0, 2e-4)) for end in ("root", "tip")]
    # The spin is about the middle.
    placed = Placed(part, velocity=(0.0, -4.0 * rate, 0.0), angular_velocity=(0.0, 0.0, rate))
    own = Run(span, span / n)
    engine = ExplicitEngine(System([placed], loads=pushes), stepped(own, safety=0.3))
    return engine, run(engine, own.times)


def frequency(part, solution):
    """Of the ends against the middle, rad/s: what fits a cosine about a constant best."""
    z = part.positions(solution.bodies["rotor"])[:, :, 2]
    ends = np.concatenate([part.body.model.mesh.node_sets[end] for end in ("root", "tip")])
    w = z[:, ends].mean(axis=1) - z[:, np.abs(part.body.nodes[:, 0] - 4) < 1e-9].mean(axis=1)
    t = solution.times

    def missed(omega):
        columns = np.column_stack([np.ones_like(t), np.cos(omega * t), np.sin(omega * t)])
        return float(np.linalg.norm(w - columns @ np.linalg.lstsq(columns, w, rcond=None)[0]))

    bounds = AROUND * part.frequencies[0]
    return minimize_scalar(missed, bounds=bounds, method="bounded", options={"xatol": 1e-8}).x


@pytest.fixture(scope="module")
def flapping(rotor):
    rate = 0.2 * rotor.frequencies[0]
    return rate, *flapped(rotor, rate)


@pytest.mark.filterwarnings("ignore::supple.errors.SuppleWarning")
@pytest.mark.slow
def test_the_frequency_of_flapping_is_that_of_the_floating_frame(body, rotor, flapping):
    rate, _, solution = flapping
    reduced = reduce(
        body, MeanAxisFrame(), NormalModes(8), derivatives=CompressedDerivatives(20), loads=NoLoads
    )
    machine = System((Placed(reduced, velocity=(0, -4 * rate, 0), angular_velocity=(0, 0, rate)),))
    poles = machine_modes(linearize(machine, spin=Spin(rate, (0, 0, 1), point=(4, 0, 0)))).eigenvalues
    # Bending in the plane and out of it: the former is softened by the spin.
    bending = np.unique(np.round(np.abs(poles.imag), 6))
    lowest, highest = AROUND * rotor.frequencies[0]
    bending = bending[(bending > lowest) & (bending < highest)]
    assert len(bending) == 2
    found = frequency(rotor, solution)
    assert found == pytest.approx(bending[1], rel=5e-4)
    assert bending[1] > 1.05 * rotor.frequencies[0]  # what modes at rest would miss


@pytest.mark.slow
def test_momentum_is_kept_and_the_balance_is_closed(flapping):
    _, engine, solution = flapping
    e = solution.series[ENERGIES]
    total = e[:, :7].sum(axis=1) - e[:, 7]
    assert np.abs(total - total[0]).max() < 1e-12 * np.abs(e).max()
    assert e[:, 1].max() > 1e-6
    model = engine.built.model.frames[0].model
    own = half_steps(engine, solution.times, "rotor")
    L = [angular_momentum(model, FrameState(*row[:4]), row[4]) for row in zip(*own, strict=True)]
    about_z = np.array(L[1:])[:, 2]  # the pushes along z have no moment about it at x = 4, y = 0
    assert np.abs(about_z - about_z[0]).max() < 1e-11 * np.abs(about_z).max()


def test_the_step_shrinks_with_the_spin_by_a_bound_of_its_stiffness(rotor):
    bound = largest_of_unit_spin(rotor.spin_stiffness, np.eye(8))
    for spin in np.random.default_rng(0).normal(size=(20, 3)):
        largest = np.linalg.eigvalsh(spun(rotor.spin_stiffness, spin))[-1]
        assert largest <= bound * spin @ spin * (1 + 1e-12)
    fast = Placed(rotor, angular_velocity=(0.0, 0.0, 1.0))
    own = stepped(Run(100.0, 100.0), safety=1.0)
    step = ExplicitEngine(System([fast]), own).steps()[0]
    expected = 2 / np.hypot(rotor.frequencies[-1], np.sqrt(bound))
    assert 0.98 * expected < step <= expected * (1 + 1e-9)
    assert expected < 0.9 * rotor.step_limit
    with pytest.raises(ModelError, match="above the stability limit"):
        ExplicitEngine(System([fast]), stepped(own, step=1.01 * expected))


def test_what_cannot_stiffen_is_refused(body, rotor):
    with pytest.raises(ModelError, match="no quadratic strains"):
        modal_subdomain(body.linearized(), NormalModes(4), stiffening=CentrifugalStiffness())
    with pytest.raises(ModelError, match="has a centrifugal stiffness"):
        ExplicitEngine(System([rotor]), stepped(Run(1.0, 1.0), scheme=PublishedScheme()))

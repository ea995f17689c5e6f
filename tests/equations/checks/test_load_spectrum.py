"""Spectra of loads against closed forms, and the modes that a reduced body lacks inside their band."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest

from supple.aero import (
    Operation,
    PowerLawShear,
    Wind,
    golden_phases,
    kaimal_series,
    prescribed_forces,
)
from supple.body import FlexibleBody, FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.equations import band_coverage, load_spectra, warn_of_missing_modes
from supple.equations.checks.load_spectrum import SHARE, LoadSpectrum, _thinned
from supple.error import ReductionStart, SelfCorrection, self_correct
from supple.errors import LoadSpectrumWarning, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.importers import nrel5mw_rotor
from supple.integrate import Run
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Fixed,
    Placed,
    PrescribedRotation,
    System,
    Table,
)
from supple.mesh import strip
from supple.reduction import NoDerivatives, NoLoads, NormalModes, ReducedBody, reduce

T = 4.0
TIMES = np.linspace(0.0, T, 801)
ROOT = NodalFixedFrame("root")


@pytest.fixture(scope="module")
def beam() -> FlexibleBody:
    """A strip of shells along x, held at its root; lowest frequencies 1.6, 10, 15 and 29 Hz."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    return flexible_body("beam", shell_model(strip(1.0, 0.1, 6, 2), wall), (RigidInterface("root", "root"),))


@pytest.fixture(scope="module")
def small(beam) -> ReducedBody:
    return reduce(beam, ROOT, NormalModes(2), derivatives=NoDerivatives(), loads=NoLoads)


def pushed(body, force) -> System:
    """The beam held at its root, forces at its tip."""
    clamp = Fixed(name="clamp", first=GROUND, second=At("beam", "root"))
    tip = [int(np.argmax(body.nodes[:, 0]))]
    return System((Placed(body),), (clamp,), (DeadForce(body="beam", at=tip, force=force),))


def spectrum_of(small, force) -> LoadSpectrum:
    (spectrum,) = load_spectra(pushed(small, force), TIMES)
    return spectrum


def test_a_parabola_has_the_series_of_the_book(small):
    """t (T - t) = sum over odd k of 8 T^2 / (k pi)^3 sin(k pi t / T); its mean square is T^4 / 30."""
    values = np.outer(TIMES * (T - TIMES), [3.0, 0.0, 4.0])
    spectrum = spectrum_of(small, Table(TIMES, values))
    k = np.arange(1, len(TIMES) - 1)
    closed = np.where(k % 2, (5 * 8 * T**2 / (k * np.pi) ** 3) ** 2 / 2, 0.0)
    np.testing.assert_allclose(spectrum.frequencies, k * np.pi / T)
    np.testing.assert_allclose(spectrum.mean_squares[:40], closed[:40], rtol=1e-3, atol=1e-12)
    np.testing.assert_allclose(spectrum.mean_squares.sum(), 25 * T**4 / 30, rtol=1e-9)  # Parseval
    assert spectrum.steady == 0.0


def test_a_windowed_harmonic_has_three_lines(small):
    """sin^2(pi t / T) sin(m pi t / T) = sin(m ..) / 2 - (sin((m + 2) ..) + sin((m - 2) ..)) / 4."""
    m = 40
    values = np.sin(np.pi * TIMES / T) ** 2 * np.sin(m * np.pi * TIMES / T)
    spectrum = spectrum_of(small, Table(TIMES, np.outer(values, [0.0, 1.0, 0.0])))
    expected = np.zeros(len(TIMES) - 2)
    expected[[m - 3, m - 1, m + 1]] = np.array([1 / 4, 1 / 2, 1 / 4]) ** 2 / 2
    np.testing.assert_allclose(spectrum.mean_squares, expected, atol=1e-15)
    assert spectrum.band == pytest.approx((m + 2) * np.pi / T)


def test_mean_squares_add_up_to_that_of_the_load(small):
    """With the line between the ends; a sine that ends at zero leaves no line, and no cross term."""

    def force(t):
        return jnp.array([0.0, 0.0, 2.0]) * jnp.sin(2 * jnp.pi * 3.0 * t)

    spectrum = spectrum_of(small, force)
    np.testing.assert_allclose(spectrum.mean_squares.sum() + spectrum.steady, 2.0, rtol=1e-9)
    assert spectrum.band == pytest.approx(2 * np.pi * 3.0)


def test_a_slow_rise_has_no_band_to_speak_of(small):
    """A smooth step to a constant: what varies beyond a few turns of the run is below a thousandth."""
    spectrum = spectrum_of(small, lambda t: jnp.array([1.0, 0.0, 0.0]) * (1 - jnp.cos(jnp.pi * t / T)))
    assert spectrum.band <= 4 * np.pi / T


def test_a_motion_excites_by_its_acceleration(beam, small):
    """phi = a sin(omega t): the mean square of its acceleration is (a omega^2)^2 / 2."""
    omega = 2 * np.pi * 5.0
    hinge = PrescribedRotation(
        name="hinge",
        first=GROUND,
        second=At("beam", "root"),
        axis=(0, 1, 0),
        angle=lambda t: 0.1 * jnp.sin(omega * t),
    )
    (spectrum,) = load_spectra(System((Placed(small),), (hinge,)), TIMES)
    assert spectrum.label == "joint 'hinge'"
    np.testing.assert_allclose(spectrum.mean_squares.sum(), (0.1 * omega**2) ** 2 / 2, rtol=1e-9)
    assert spectrum.band == pytest.approx(omega)


def harmonic(frequency):
    return lambda t: jnp.array([0.0, 0.0, 1.0]) * jnp.sin(2 * jnp.pi * frequency * t)


def test_a_force_between_the_modes_kept_is_no_reason_to_warn(beam, small, recwarn):
    coverage = warn_of_missing_modes(pushed(small, harmonic(9.0)), TIMES, beam, small)
    assert coverage is not None
    assert coverage.missing == ()
    assert coverage.n_modes == 1
    assert coverage.band == pytest.approx(2 * np.pi * 9.0)
    assert coverage.kept == pytest.approx(small.frequencies[1], rel=1e-6)
    assert not recwarn


def test_a_force_beyond_the_modes_kept_names_those_to_ask_for(beam):
    of_body = NormalModes(4).build(beam, ROOT).frequencies / (2 * np.pi)
    assert of_body[2] < 24.0 < of_body[3]
    tiny, enough = (
        reduce(beam, ROOT, NormalModes(n), derivatives=NoDerivatives(), loads=NoLoads) for n in (1, 3)
    )
    with pytest.warns(
        LoadSpectrumWarning, match=r"the 3 modes .* 2 are missing from its basis.*at least 3 modes"
    ):
        coverage = warn_of_missing_modes(pushed(tiny, harmonic(24.0)), TIMES, beam, tiny)
    assert coverage is not None
    np.testing.assert_allclose(np.array(coverage.missing) / (2 * np.pi), of_body[1:3], rtol=1e-6)
    assert coverage.n_modes == 3
    coverage = warn_of_missing_modes(pushed(enough, harmonic(24.0)), TIMES, beam, enough)
    assert coverage is not None
    assert coverage.missing == ()


def test_steady_loads_excite_nothing(beam, small):
    assert warn_of_missing_modes(pushed(small, [0.0, 0.0, 1.0]), TIMES, beam, small) is None
    assert band_coverage((), small.frequencies, small.frequencies) is None


def test_a_mode_left_out_between_kept_ones_is_found():
    """The reduced body has modes 1, 3 and a column of no mode at all."""
    spectrum = LoadSpectrum("wind", np.array([1.0, 10.0]), np.array([1.0, 1.0]), 0.0)
    coverage = band_coverage([spectrum], np.array([1.0, 3.01, 50.0]), np.array([1.0, 2.0, 3.0, 11.0]))
    assert coverage is not None
    assert coverage.missing == (2.0,)
    assert coverage.kept == 1.0
    assert coverage.n_modes == 3


def test_the_wind_on_the_blade_stays_below_its_first_modes(beam, small):
    """Turbulent wind at rated speed, 20 s: nearly all of its load varies below the second edgewise mode."""
    times = np.arange(0.0, 20.01, 0.05)
    wind = Wind(
        mean_speed=12.0,
        shear=PowerLawShear(hub_height=90.0),
        turbulence=kaimal_series(
            mean_speed=12.0, deviation=1.2, length_scale=340.2, frequency_step=0.01, phase=golden_phases(50)
        ),
    )
    run = Operation(angular_speed=1.267, pitch=np.radians(3.4))
    span = np.array([0.0, 10.0, 18.0, 33.0, 50.0, 61.5])
    nodal = prescribed_forces(nrel5mw_rotor(), run, wind, span=span, hub_radius=1.5, times=times)
    load = DeadForce(body="beam", at=list(range(6)), force=Table(nodal.times, nodal.forces))
    clamp = Fixed(name="clamp", first=GROUND, second=At("beam", "root"))
    (spectrum,) = load_spectra(System((Placed(small),), (clamp,), (load,)), times)
    assert 0.0 < spectrum.band / (2 * np.pi) < 2.37
    assert spectrum.steady > 10 * spectrum.mean_squares.sum()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::supple.errors.ResolutionWarning")  # coarse steps
def test_self_correction_looks_at_the_loads(beam):
    """A harmonic force near the third mode, where the start has one."""
    full = FullBody(beam.linearized(), ROOT)
    start = ReductionStart(SelfCorrection(relative=0.9, instants=2), NormalModes(1), NoDerivatives())
    with pytest.warns(LoadSpectrumWarning, match="frequencies of DeadForce on 1 nodes of 'beam' reach 12"):
        self_correct(pushed(full, harmonic(12.0)), Run(duration=1.0, output_step=0.02), start)


def test_times_must_be_evenly_spaced(small):
    system = pushed(small, harmonic(1.0))
    for times in (np.array([0.0, 1.0]), np.array([0.0, 1.0, 3.0])):
        with pytest.raises(ModelError, match="at least three evenly spaced times"):
            load_spectra(system, times)


def test_a_run_of_one_output_interval_is_looked_at(beam):
    """Its steps see the load all the same, and so does the check."""
    tiny = reduce(beam, ROOT, NormalModes(1), derivatives=NoDerivatives(), loads=NoLoads)
    with pytest.warns(LoadSpectrumWarning, match="at least 3 modes"):
        warn_of_missing_modes(pushed(tiny, harmonic(24.0)), np.array([0.0, TIMES[-1]]), beam, tiny)


def test_long_runs_are_sampled_more_coarsely():
    times = np.linspace(0.0, 100.0, 1_000_001)
    assert len(_thinned(times)) == 20_000
    assert _thinned(times)[-1] == 100.0
    assert SHARE == 0.999

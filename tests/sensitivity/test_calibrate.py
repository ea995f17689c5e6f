"""Parameters found again from measurements, how sure they are, and what the measurements do not see."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import RigidBody
from supple.errors import IdentifiabilityWarning, ModelError
from supple.integrate import FixedStep, Run
from supple.machine import Placed, Prismatic, SpringDamper, System
from supple.quantities import Place, PositionSensor
from supple.sensitivity import Measurement, calibrate
from supple.sensitivity.calibration import uncertainty
from supple.simulation import simulate

TRUE = {"stiffness": 100.0, "damping": 1.5}
RUN = Run(1.2, 0.02, FixedStep(0.02))
X = PositionSensor("x", Place("block", "centre"))


def let_go(parameters):
    """A mass on a spring, let go 0.1 m off its rest; a second spring beside it, if that has a stiffness."""
    block = RigidBody("block", 2.0, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})
    spring = {"first": "ground", "second": "block.centre", "anchor": (-1.0, 0, 0), "rest_length": 0.9}
    springs = [
        SpringDamper(**spring, stiffness=parameters["stiffness"], damping=parameters["damping"]),
        SpringDamper(**spring, stiffness=parameters.get("second", 0.0)),
    ]
    slide = Prismatic(first="ground", second="block.centre", axis=(1, 0, 0), name="slide")
    return System([Placed(block)], [slide], loads=springs)


def measured():
    system = let_go(TRUE)
    solution = simulate(system, RUN)
    return solution.times, X.values(system, solution)[:, 0]


@pytest.mark.slow
def test_parameters_of_an_exact_measurement_are_found_again():
    """Also between output times, and where some times were not measured."""
    times, values = measured()
    values = np.where(np.arange(len(times)) % 5 == 3, np.nan, values)
    start = {"stiffness": 80.0, "damping": 3.0}
    fit = calibrate(let_go, start, RUN, [X], [Measurement("x", times, values, "x")])
    for name, value in TRUE.items():
        assert fit.parameters[name] == pytest.approx(value, rel=1e-7)
    assert fit.misfit < 1e-18
    assert fit.at_bounds == ()
    assert fit.runs < 20
    assert "stiffness  100 +-" in str(fit)


def test_a_step_to_values_that_no_machine_has_is_shortened():
    """From a damping of 12 the first steps are to zero and below, which a spring refuses."""
    little = {"stiffness": 100.0, "damping": 0.1}
    system = let_go(little)
    solution = simulate(system, RUN)
    given = Measurement("x", solution.times, X.values(system, solution)[:, 0], "x")
    tried = []

    def build(parameters):
        tried.append(parameters["damping"])
        return let_go({**little, **parameters})

    fit = calibrate(build, {"damping": 12.0}, RUN, [X], [given])
    assert min(tried) < 0
    assert fit.parameters["damping"] == pytest.approx(0.1, rel=1e-6)


@pytest.mark.slow
def test_the_covariance_is_that_of_many_fits():
    """60 fits of the same motion with other noise: deviations and correlation within their own scatter."""
    times, values = measured()
    noise = 0.01
    draws = np.random.default_rng(7).normal(size=(60, len(times))) * noise

    def fitted(own):
        return calibrate(let_go, TRUE, RUN, [X], [Measurement("x", times, values + own, deviation=noise)])

    fits = [fitted(own) for own in draws]
    found = np.array([list(fit.parameters.values()) for fit in fits])
    covariance = fits[0].uncertainty.covariance
    scatter = np.cov(found.T)
    # The scatter of 60 draws has a standard deviation of 18 % itself.
    np.testing.assert_allclose(np.diag(scatter) / np.diag(covariance), 1.0, atol=0.55)
    bias = abs(found.mean(axis=0) - list(TRUE.values()))
    assert np.all(bias < 4 * fits[0].uncertainty.deviations / np.sqrt(60))
    assert np.mean([fit.misfit for fit in fits]) == pytest.approx(1.0, abs=0.1)
    # A deviation that is not known follows from the residuals.
    alone = calibrate(let_go, TRUE, RUN, [X], [Measurement("x", times, values + draws[0])])
    assert np.sqrt(alone.misfit) == pytest.approx(noise, rel=0.3)
    np.testing.assert_allclose(alone.uncertainty.covariance, covariance * alone.misfit / noise**2, rtol=0.05)


@pytest.mark.slow
def test_springs_side_by_side_are_not_determined():
    """Only the sum of their stiffnesses moves anything: the fit reports the difference as undetermined."""
    times, values = measured()
    start = {"stiffness": 60.0, "second": 30.0, "damping": 1.0}
    with pytest.warns(IdentifiabilityWarning, match="do not determine second, stiffness"):
        fit = calibrate(let_go, start, RUN, [X], [Measurement("x", times, values)])
    assert fit.parameters["stiffness"] + fit.parameters["second"] == pytest.approx(100.0, rel=1e-6)
    (blind,) = fit.uncertainty.undetermined
    assert set(blind) == {"stiffness", "second"}
    # In parts of 60 and 30 N/m.
    assert blind["second"] / blind["stiffness"] == pytest.approx(-2.0, rel=1e-3)
    deviations = dict(zip(start, fit.uncertainty.deviations, strict=True))
    assert np.isinf(deviations["stiffness"])
    assert np.isinf(deviations["second"])
    assert np.isfinite(deviations["damping"])


def test_the_covariance_of_a_straight_line_is_that_of_linear_regression():
    """`y = a + b t` with deviation s: var b = s^2 / sum (t - mean)^2."""
    times = np.linspace(0, 3, 31)
    jacobian = np.column_stack([np.ones(31), times]) / 0.2
    found = uncertainty(jacobian, {"a": 1e3, "b": 1e-3}, 1.0)
    spread = np.sum((times - times.mean()) ** 2)
    assert found.deviations[1] == pytest.approx(0.2 / np.sqrt(spread), rel=1e-12)
    expected = -times.mean() / np.sqrt(np.mean(times**2))
    assert found.correlation[0, 1] == pytest.approx(expected, rel=1e-12)
    assert found.undetermined == ()


def test_measurements_that_fit_no_run_are_refused():
    times, values = measured()

    def fit(*measurements, **more):
        return calibrate(let_go, TRUE, RUN, [X], measurements, **more)

    with pytest.raises(ModelError, match="needs ascending times"):
        Measurement("x", times, values[:-1])
    with pytest.raises(ModelError, match="give a positive deviation"):
        Measurement("x", times, values, deviation=0.0)
    with pytest.raises(ModelError, match=r"go beyond the run from 0 to 1\.2"):
        fit(Measurement("x", times + 0.5, values))
    with pytest.raises(ModelError, match="no such observable, only x"):
        fit(Measurement("y", times, values))
    with pytest.raises(ModelError, match="no channel 'w', only x, y, z"):
        fit(Measurement("x", times, values, "w"))
    with pytest.raises(ModelError, match="need as many measured values, and there are 1"):
        fit(Measurement("x", times[:1], values[:1]))
    with pytest.raises(ModelError, match="have no deviation"):
        fit(Measurement("x", times, values), Measurement("x", times, values, "y", 0.1))
    with pytest.raises(ModelError, match="do not contain the initial value"):
        fit(Measurement("x", times, values), bounds={"stiffness": (1.0, 50.0)})

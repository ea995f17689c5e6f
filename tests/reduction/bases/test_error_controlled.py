"""A tolerance in, a proven basis out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import linalg, sparse

from supple.body import (
    AveragingInterface,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.errors import AccuracyError, ModelError
from supple.fem import HomogeneousSection, Isotropic, lumped_mass, shell_model, solid_model
from supple.mesh import CellType, block, strip
from supple.reduction import (
    ErrorControlled,
    FirstOrderEstimate,
    Han2020Bound,
    NoDerivatives,
    NoLoads,
    OneByOne,
    TwoTermEstimate,
    count_eigenvalues,
    error_controlled_modes,
    reduce,
)

N = 8


def model():
    return solid_model(block(2.0, 0.5, 0.3, 8, 2, 2, CellType.TETRA4), Isotropic(1e7, 0.3, 1000.0))


@pytest.fixture(scope="module", params=["rigid", "averaging", "two, lumped mass"])
def body(request):
    if request.param == "rigid":
        return flexible_body("block", model(), [RigidInterface("root", "root")])
    if request.param == "averaging":
        return flexible_body("block", model(), [AveragingInterface("root", "root")])
    lumped = replace(model(), mass=sparse.csc_array(sparse.diags_array(lumped_mass(model()))))
    return flexible_body("block", lumped, [RigidInterface("root", "root"), AveragingInterface("tip", "tip")])


@pytest.fixture(scope="module")
def rigid_body():
    return flexible_body("block", model(), [RigidInterface("root", "root")])


@pytest.fixture(scope="module")
def exact(body, lowest_squares):
    return lowest_squares(body, MeanAxisFrame(), N)


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_every_eigenvalue_is_within_the_tolerance_and_proven_so(body, exact, tolerance):
    modes = error_controlled_modes(body, ErrorControlled(tolerance, N))
    certificate = modes.certificate
    errors = certificate.values / exact - 1
    assert np.all(errors > -1e-9)
    assert np.all(errors <= tolerance)
    assert certificate.largest_error <= tolerance
    assert np.all(certificate.errors >= errors - 1e-9)
    np.testing.assert_allclose(certificate.errors, errors, atol=0.011 * tolerance)
    assert all(group.proven for group in count_eigenvalues(body, certificate.values, tolerance))
    assert f"{N} eigenvalues, each within {100 * tolerance:g} %, none missed" in str(certificate)


def test_one_mode_less_would_not_do(body, exact):
    """The last step is the smallest of those that pass; the one below it was tried, and failed."""
    certificate = error_controlled_modes(body, ErrorControlled(0.001, N)).certificate
    tried = {step.n_modes: step for step in certificate.steps}
    last = certificate.n_fixed_interface_modes
    assert certificate.steps[-1].n_modes == last
    assert tried[last].first_failing is None
    assert tried[last - 1].first_failing is not None


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_both_searches_keep_as_many_modes(body, tolerance):
    control = ErrorControlled(tolerance, N)
    bisected = error_controlled_modes(body, control)
    published = error_controlled_modes(body, replace(control, search=OneByOne()))
    kept = bisected.certificate.n_fixed_interface_modes
    assert kept == published.certificate.n_fixed_interface_modes
    np.testing.assert_allclose(bisected.certificate.values, published.certificate.values, rtol=1e-8)


def test_sharper_estimates_keep_fewer_modes(rigid_body):
    kept = [
        error_controlled_modes(
            rigid_body, ErrorControlled(0.001, N, estimator=estimator)
        ).certificate.n_fixed_interface_modes
        for estimator in (TwoTermEstimate(), Han2020Bound())
    ]
    assert kept[0] < kept[1]


@dataclass(frozen=True)
class Optimist:
    """Everything is fine."""

    def errors(self, terms):
        return np.zeros_like(terms.values)


@pytest.mark.parametrize("estimator", [Optimist(), FirstOrderEstimate()])
def test_the_bounds_correct_an_estimate_that_promises_too_much(body, exact, estimator):
    certificate = error_controlled_modes(body, ErrorControlled(0.01, N, estimator=estimator)).certificate
    assert np.all(certificate.values / exact - 1 <= 0.01)
    if isinstance(estimator, Optimist):
        assert {step.criterion for step in certificate.steps} == {"Optimist", "KnownEigenvalues"}


@pytest.mark.parametrize("frame", [MeanAxisFrame(), NodalFixedFrame("root")])
def test_the_reduced_body_has_those_eigenvalues_in_either_frame(body, exact, frame):
    reduced = reduce(
        body.linearized(), frame, ErrorControlled(0.001, N), derivatives=NoDerivatives(), loads=NoLoads
    )
    r = reduced.r
    assert r == N
    fields = np.r_[0:6, 6 + 3 * r : 6 + 4 * r]
    mass = reduced.gram[np.ix_(fields, fields)]
    stiffness = linalg.block_diag(np.zeros((6, 6)), reduced.stiffness)
    free = linalg.eigh(stiffness, mass, eigvals_only=True)
    errors = free[6:] / exact - 1
    assert np.all(errors > -1e-7)
    assert np.all(errors <= 0.001)
    assert reduced.report.certificate is not None
    np.testing.assert_allclose(free[6:], reduced.report.certificate.values, rtol=1e-6)


def test_modal_coordinates_are_diagonal_in_the_mean_axis_frame(rigid_body):
    """[Han2020] (46)-(49): M = I, K = diag(chi-bar)."""
    reduced = reduce(
        rigid_body, MeanAxisFrame(), ErrorControlled(0.01, N), derivatives=NoDerivatives(), loads=NoLoads
    )
    values = reduced.report.certificate.values
    scaled = reduced.stiffness / np.sqrt(np.outer(values, values))
    np.testing.assert_allclose(scaled, np.eye(N), atol=1e-8)
    assert reduced.report.linear == tuple(f"error-controlled mode {i + 1}" for i in range(N))


def test_progress_sees_every_step(rigid_body):
    seen = []
    control = ErrorControlled(0.01, N, progress=seen.append)
    certificate = error_controlled_modes(rigid_body, control).certificate
    assert sorted(step.n_modes for step in seen) == sorted(step.n_modes for step in certificate.steps)
    assert all(step.seconds > 0 for step in seen)
    assert set(certificate.seconds) == {"modes and search", "enclosure", "modes added"}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"tolerance": 0.0}, "the tolerance is 0: give a relative error of the eigenvalues between 0 and 1"),
        ({"tolerance": -0.1}, "the tolerance is -0.1"),
        ({"tolerance": 1.0}, "the tolerance is 1: "),
        ({"tolerance": float("nan")}, "the tolerance is nan"),
        ({"tolerance": 1e-9}, "the tolerance 1e-09 is below the round-off.*give 1e-07 or more"),
        ({"n_modes": 0}, "n_modes = 0"),
        ({"start": -1}, "start = -1"),
        ({"most": 3}, "start = 5, most = 3: give n_modes of one or more, and 0 <= start <= most"),
    ],
)
def test_numbers_that_make_no_sense(wrong, message):
    with pytest.raises(ModelError, match=message):
        ErrorControlled(**{"tolerance": 0.01, "n_modes": N, **wrong})


def test_more_than_the_body_has(rigid_body, loose_body):
    n = rigid_body.n - 6
    with pytest.raises(ModelError, match=rf"{n} eigenvalues requested of body 'block', which has {n} "):
        error_controlled_modes(rigid_body, ErrorControlled(0.01, n))
    with pytest.raises(ModelError, match=rf"{n + 1} fixed-interface modes at the start, .* has {n}"):
        error_controlled_modes(rigid_body, ErrorControlled(0.01, N, start=n + 1))
    with pytest.raises(ModelError, match="a Craig-Bampton body needs interfaces"):
        error_controlled_modes(loose_body, ErrorControlled(0.01, 3))


def test_a_tolerance_that_the_modes_allowed_do_not_reach(rigid_body):
    message = (
        r"with 20 fixed-interface modes, the error of eigenvalue \d of 8 is .*, above the tolerance 1.0e-03 "
        r"\(SharperBound\); "
        "loosen the tolerance or allow more than most = 20 modes"
    )
    with pytest.raises(AccuracyError, match=message):
        error_controlled_modes(rigid_body, ErrorControlled(0.001, N, most=20))


def test_memory_given_back_for_the_count_changes_nothing(monkeypatch, strip_body):
    """What a large body gives back (its factor, its Krylov space) is made again where it is needed."""
    control = ErrorControlled(1e-3, 8)
    kept = error_controlled_modes(strip_body, control)
    monkeypatch.setattr("supple.reduction.bases.error_controlled.LARGEST_WITH_TWO_FACTORS", 0)
    given_back = error_controlled_modes(strip_body, control)
    assert str(given_back.certificate) == str(kept.certificate)
    np.testing.assert_allclose(given_back.certificate.values, kept.certificate.values, rtol=1e-9)
    np.testing.assert_allclose(np.abs(given_back.vectors), np.abs(kept.vectors), atol=1e-6)


def test_a_foil_too_thin_for_its_digits_is_refused():
    """0.1 mm by 10 m: the lowest eigenvalue is 10^-20 of the highest, far below round-off."""
    model = shell_model(strip(10.0, 0.4, 8, 2), HomogeneousSection(Isotropic(7e10, 0.3, 2700.0), 1e-4))
    foil = flexible_body("foil", model, [RigidInterface("root", "root")])
    with pytest.raises(AccuracyError, match=r"lowest eigenvalue of the structure is -.*so soft"):
        error_controlled_modes(foil, ErrorControlled(1e-3, 6))

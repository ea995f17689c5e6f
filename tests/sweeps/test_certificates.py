"""What is concluded from a few statements, and which cases run again because of it; no run is made."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from error.equation.machines import NODAL, soft_strip
from fixtures.report_page import ReadPage

from supple.body import FullBody
from supple.error import ErrorIndicator, IndicatorBody, SelfCorrection
from supple.error.equation import ErrorSpace, MotionColumns
from supple.sweeps import CaseTable, make_plan, plan_sweep, sweep_status, write_sweep_report
from supple.sweeps.certificate import Certificate, Representative, read_certificate, write_certificate
from supple.sweeps.certified_group import certified_group
from supple.sweeps.greedy_basis import training_cases
from supple.sweeps.part_file import CaseRecord, CaseStatus, Channels, Part, part_path, write_part
from supple.sweeps.plan import write_plan
from supple.sweeps.read_sweep import SweepColumns
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.sweep_shares import sweep_shares


def stated(case, basis, indicator, final, *, others=1e-5, size=0.1):
    """A representative case of a beam."""
    return Representative(case, "beam", basis, others, indicator, final, size)


ROWS = (stated(3, 2e-4, np.nan, 1e-4), stated(7, 3e-4, 1e-4, 2.5e-4, size=0.2))


def test_the_largest_ratio_scales_all_indicators():
    certificate = Certificate({}, ROWS, {"beam": SelfCorrection(relative=1e-3)})
    # 2, and of the second 3 before its motion joined the columns and 1.2 after.
    assert certificate.effectivity("beam") == pytest.approx(3.0)
    assert certificate.spread("beam") == pytest.approx(3.0 / 1.2)
    assert certificate.other_share("beam") == pytest.approx(1e-4)
    error = certificate.case_error(0, {"beam": ErrorIndicator(1e-4, 0.2)})
    assert error == pytest.approx((3e-4 + 2e-5, 3e-4, 2e-4))
    assert all(row.basis <= certificate.effectivity("beam") * row.final for row in ROWS)


def test_of_several_bodies_the_one_that_exceeds_its_accuracy_counts():
    rows = (*ROWS, Representative(3, "arm", 1e-6, 0.0, np.nan, 1e-6, 0.1))
    targets = {"beam": SelfCorrection(absolute=1.0), "arm": SelfCorrection(absolute=1e-7)}
    error = Certificate({}, rows, targets).case_error(
        0, {"beam": ErrorIndicator(1e-4, 0.2), "arm": ErrorIndicator(5e-7, 0.1)}
    )
    assert (error.basis, error.allowed) == pytest.approx((5e-7, 1e-7))
    # Of two that exceed it, the one with the larger ratio, though its error is the smaller one.
    both = Certificate({}, rows, targets | {"beam": SelfCorrection(absolute=1e-4)}).case_error(
        0, {"beam": ErrorIndicator(1e-4, 0.2), "arm": ErrorIndicator(5e-7, 0.1)}
    )
    assert both == error


def test_the_estimate_of_a_representative_is_its_full_estimate():
    certificate = Certificate({}, ROWS, {"beam": SelfCorrection(relative=1e-3)})
    indicated = {"beam": ErrorIndicator(1e-4, 0.1)}
    assert certificate.case_error(3, indicated) == pytest.approx((2e-4 + 1e-5, 2e-4, 1e-4))
    assert certificate.case_error(4, indicated).basis == pytest.approx(3e-4)


def test_no_estimate_is_no_number():
    assert np.isnan(
        Certificate(reason="no body is elastic").case_error(0, {"beam": ErrorIndicator(1.0, 1.0)})
    ).all()
    assert np.isnan(Certificate().case_error(0, {})).all()
    assert np.isinf(Certificate({}, ROWS).case_error(0, {"beam": ErrorIndicator(np.inf, 0.1)}).estimated)
    # Errors of nothing, as of a complete basis, have no ratio.
    assert Certificate({}, (stated(0, 1e-14, 1e-17, 1e-17),)).effectivity("beam") == 1.0


def test_a_part_that_is_not_requested_is_the_reason_without_a_sum():
    """With `integration = false` the basis error is known and the sum is not."""
    certificate = Certificate({}, (stated(3, 2e-4, np.nan, 1e-4, others=np.nan),))
    error = certificate.case_error(0, {"beam": ErrorIndicator(1e-4, 0.2)})
    assert np.isnan(error.estimated)
    assert error.basis == pytest.approx(2e-4)
    assert "remove integration = false" in certificate.why_no_estimate
    assert "indicator could not be computed" in Certificate({}, ROWS).why_no_estimate
    assert Certificate(reason="no body is elastic").why_no_estimate == "no body is elastic"


def test_a_certificate_is_kept(tmp_path):
    full = FullBody(soft_strip("beam", 1.0), NODAL)
    rng = np.random.default_rng(1)
    vectors, following = rng.normal(size=(full.n_coordinates, 5)), rng.normal(size=(3, 3))
    columns = MotionColumns(vectors[:, :3], following, rng.normal(size=(6, 3)))
    made = Certificate({"beam": IndicatorBody(full, columns, ErrorSpace(vectors, 3))}, ROWS, reason="")
    write_certificate(tmp_path / "c.h5", made)
    read = read_certificate(tmp_path / "c.h5", {"beam": full}, {})
    assert read.representatives[1] == ROWS[1]
    assert np.isnan(read.representatives[0].indicator)
    own = read.bodies["beam"]
    assert np.array_equal(own.space.vectors, vectors)
    assert np.array_equal(own.columns.vectors, vectors[:, :3])
    assert np.array_equal(own.columns.following, following)
    assert np.array_equal(own.columns.rigid, columns.rigid)


@pytest.fixture
def planned(pendulum, tmp_path):
    """A sweep of 40 cases in four shares of two groups, none of which has run."""
    table = CaseTable(
        {
            "gravity[2]": [-0.1 * number for number in range(40)],
            "simulation.duration": [0.1] * 20 + [0.2] * 20,
        }
    )
    plan = make_plan(pendulum, table, SweepOutput.model_validate({"cases_per_share": 10}))
    folder = tmp_path / "out"
    folder.mkdir()
    write_plan(folder, plan)
    return folder, plan


def filled(folder, cases, share, basis):
    """Write a part whose cases have given errors of their bases; 1 is allowed. One cycle a case."""
    channels = Channels(("tip",), ("m",), ("position",), ("",), ("",))
    results = [
        CaseRecord(
            int(case),
            CaseStatus.RAN,
            estimated_error=2 * own,
            basis_error=own,
            allowed_error=1.0,
            statistics=np.full((6, 1), own),
            channels=channels,
        )
        for case, own in zip(cases, basis, strict=True)
    ]
    part_path(folder, share).parent.mkdir(exist_ok=True)
    write_part(part_path(folder, share), Part(results))


def test_cases_above_their_accuracy_run_again_and_no_others(planned):
    folder, plan = planned
    assert sweep_shares(folder, plan).missing == [0, 1, 2, 3]
    error = np.full(40, 0.4)
    error[[3, 8, 15, 16, 38]] = [1.5, 1.2, 3.0, 1.1, np.inf]
    for share in range(4):
        filled(folder, plan.cases_of(share), share, error[plan.cases_of(share)])
        again = sweep_shares(folder, plan)
        assert len(again.cases) == (4 if share < 3 else 6), "known once all have run"
    assert [own.tolist() for own in again.cases[4:]] == [[3, 8, 15, 16], [38]]
    assert (again.missing, again.level[4:]) == ([4, 5], [1, 1])
    assert sweep_status(folder).exit_code == 4
    # One of them is still above; another level, which is the last.
    filled(folder, [3, 8, 15, 16], 4, [0.2, 0.1, 1.3, 0.3])
    filled(folder, [38], 5, [0.1])
    again = sweep_shares(folder, plan)
    assert [own.tolist() for own in again.cases[6:]] == [[15]]
    assert again.cases_of_level(2, 0) == [15]
    filled(folder, [15], 6, [1.2])
    status = sweep_status(folder)
    assert (status.missing, status.n_ran, status.n_again, status.exit_code) == ((), 40, 5, 0)
    # By all parts: twice the error of the basis, of which 1 is allowed.
    assert (status.errors.largest, status.errors.n_above) == (2.4, 1)
    page = ReadPage(write_sweep_report(folder))
    text, ratios = page.text, page.cases()["estimated / allowed"]
    assert ratios[[3, 15, 39]].tolist() == [0.4, 2.4, 0.8]
    assert (
        "40 of 40 cases have an estimate, the largest is 2.4 m; 5 run again, 1 above their accuracy." in text
    )
    assert "Estimated over allowed error: 0.2 to 2.4, median 0.8; largest in case 15." in text
    columns = SweepColumns(folder)
    assert columns.of_cases("basis_error")[[3, 15, 16, 38]].tolist() == [0.2, 1.2, 0.3, 0.1]
    assert columns.statistic(0, 0)[[3, 15, 38, 39]].tolist() == [0.2, 1.2, 0.1, 0.4]
    assert columns.runs[[3, 15, 39]].tolist() == [2, 3, 1]


def test_a_lost_part_is_the_only_one_missing(planned):
    folder, plan = planned
    error = np.full(40, 0.4)
    error[5] = 2.0
    for share in range(4):
        filled(folder, plan.cases_of(share), share, error[plan.cases_of(share)])
    filled(folder, [5], 4, [0.5])
    part_path(folder, 0).unlink()
    assert sweep_shares(folder, plan).missing == [0]
    filled(folder, plan.cases_of(0), 0, error[:10])
    assert sweep_shares(folder, plan).missing == []


def test_cases_that_run_first_hold_the_extremes(planned):
    plan = planned[1]
    chosen = training_cases(plan, list(range(20)))
    assert len(chosen) == len(set(chosen)) <= 16
    assert {0, 19} <= set(chosen)
    assert training_cases(plan, [4, 9]) == [4, 9]


def test_few_cases_run_again_in_shares_and_with_certificates_of_their_own(planned):
    """Other processes then run in parallel; for more cases, one certificate costs less."""
    folder, plan = planned
    error = np.full(40, 0.4)
    error[[1, 5, 12, 20, 21, 22, 23]] = 1.5
    for share in range(4):
        filled(folder, plan.cases_of(share), share, error[plan.cases_of(share)])
    again = sweep_shares(folder, plan)
    assert [own.tolist() for own in again.cases[4:]] == [[1], [5], [12], [20, 21, 22, 23]]
    assert [again.is_certified_alone(case, 1) for case in (1, 5, 12, 20)] == [True, True, True, False]
    # Of the four with one certificate, one runs a third time: alone.
    for share, cases in enumerate(again.cases[4:], start=4):
        filled(folder, cases, share, [1.2 if case == 21 else 0.5 for case in cases])
    again = sweep_shares(folder, plan)
    assert [own.tolist() for own in again.cases[8:]] == [[21]]
    assert (again.is_certified_alone(21, 1), again.is_certified_alone(21, 2)) == (False, True)


def test_a_certificate_of_a_replaced_sweep_is_none_of_the_new_one(planned, pendulum, monkeypatch):
    """The former sweep writes its certificate after another sweep was planned in its folder."""
    folder, former = planned
    module = sys.modules["supple.sweeps.certified_group"]
    now = make_plan(pendulum, CaseTable({"gravity[2]": [-1.0]}), SweepOutput())
    nothing = SimpleNamespace(reduced={})
    group = SimpleNamespace(bodies=nothing, targets={}, like=None, fulls=lambda _: {})

    def overtaken(_folder, _group, _number, _level, own, _alone):
        plan_sweep(now, folder, force=True)
        own.mkdir(parents=True)
        write_certificate(own / "certificate.h5", Certificate(reason="of the former"))

    def certified(_folder, _group, _number, _level, own, _alone):
        write_certificate(own / "certificate.h5", Certificate(reason="own"))

    monkeypatch.setattr(module, "swept_group", lambda *_: group)
    monkeypatch.setattr(module, "_why_not", lambda _: "")
    monkeypatch.setattr(module, "_certify", overtaken)
    assert certified_group(folder, former, 0).certificate.reason == "of the former"
    monkeypatch.setattr(module, "_certify", certified)
    assert certified_group(folder, now, 0).certificate.reason == "own"

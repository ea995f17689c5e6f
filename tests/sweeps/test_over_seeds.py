"""Statistics over seeds: those of the cases of each condition, whatever the order of the table."""

import numpy as np
import pytest
from fixtures.report_page import ReadPage

from supple.errors import CaseError
from supple.sweeps import CaseTable, make_plan, plan_sweep, read_sweep, statistics_over_seeds
from supple.sweeps.over_seeds import conditions_of, over_conditions
from supple.sweeps.run_share import run_share
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.sweep_report import write_sweep_report

TABLE = CaseTable(
    {
        "gravity[2]": [-9.0, -5.0, -9.0, -5.0, -9.0],
        "body.bob.rigid.mass": [1.0, 1.0, 2.0, 2.0, 3.0],
        "wind": [8, 6, 8, 6, 8],
    }
)
OUTPUT = {"labels": ["wind"], "seeds": ["body.bob.rigid.mass"]}


def test_conditions_are_the_rows_without_their_seeds():
    numbers, conditions = conditions_of(TABLE, ["body.bob.rigid.mass"])
    assert numbers.tolist() == [0, 1, 0, 1, 0]
    assert conditions.columns == {"gravity[2]": (-9.0, -5.0), "wind": (8, 6)}
    numbers, conditions = conditions_of(TABLE, list(TABLE.columns))
    assert numbers.tolist() == [0] * 5
    with pytest.raises(CaseError, match=r"no column is named 'body\.bob\.rigid\.mas'; did you mean"):
        conditions_of(TABLE, ["body.bob.rigid.mas"])


def test_statistics_are_those_of_each_condition():
    rng = np.random.default_rng(1)
    numbers = rng.permutation(np.repeat([0, 1, 2], [5, 4, 1]))
    values = rng.normal(size=(10, 3))
    values[np.flatnonzero(numbers == 1)[0]] = np.nan
    found = over_conditions(values, numbers)
    for condition in (0, 1):
        own = values[numbers == condition]
        own = own[np.isfinite(own).all(axis=1)]
        assert found.number[condition].tolist() == [len(own)] * 3
        np.testing.assert_allclose(found.mean[condition], own.mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(found.deviation[condition], own.std(axis=0, ddof=1), rtol=1e-12)
        assert np.array_equal(found.minimum[condition], own.min(axis=0))
        assert np.array_equal(found.maximum[condition], own.max(axis=0))
    assert np.isnan(found.deviation[2]).all(), "one case has no deviation"
    none = over_conditions(np.full((10, 1), np.nan), numbers)
    assert none.number.sum() == 0
    assert np.isnan(none.mean).all()
    assert np.isnan(none.maximum).all()


def test_labels_and_seeds_of_a_sweep(pendulum, tmp_path):
    """A label is no path of the case file and changes nothing; seeds have a page of their own."""
    folder = tmp_path / "out"
    plan = make_plan(pendulum, TABLE, SweepOutput.model_validate(OUTPUT))
    assert set(plan.places) == {"gravity[2]", "body.bob.rigid.mass"}
    assert plan.group.tolist() == [0] * 5
    plan_sweep(plan, folder)
    run_share(str(folder), 0)
    read = read_sweep(folder)
    assert read.wind.values.tolist() == [8, 6, 8, 6, 8]
    over = statistics_over_seeds(read)
    highest = read.statistics.sel(channel="joint hinge.Fx", statistic="maximum").values
    own = over.sel(channel="joint hinge.Fx", statistic="maximum")
    assert own["number"].values.tolist() == [3, 2]
    assert own["gravity[2]"].values.tolist() == [-9.0, -5.0]
    np.testing.assert_allclose(own["mean"].values, [highest[::2].mean(), highest[1::2].mean()], rtol=1e-12)
    assert own["maximum"].values[0] == highest[4]
    write_sweep_report(folder)
    page = (folder / "conditions.html").read_text()
    assert "5 cases form 2 conditions of 2 to 3 cases." in page
    assert "The cases of a condition differ only in body.bob.rigid.mass." in page
    assert "joint hinge.Fx, maximum, mean over seeds" in page
    assert ReadPage(folder / "conditions.html").head["sweep"]["rows"] == "conditions"
    assert ReadPage(folder / "sweep.html").head["sweep"]["rows"] == "cases"
    with pytest.raises(CaseError, match=r"'gravity\[2\]' is a path of the case file"):
        make_plan(pendulum, TABLE, SweepOutput.model_validate({"labels": ["wind", "gravity[2]"]}))
    plan_sweep(
        make_plan(pendulum, TABLE, SweepOutput.model_validate({"labels": ["wind"]})), folder, force=True
    )
    run_share(str(folder), 0)
    write_sweep_report(folder)
    assert not (folder / "conditions.html").exists()
    for wrong in ({"labels": ["wnd"]}, {"seeds": ["wnd"]}):
        with pytest.raises(CaseError, match="no column is named 'wnd'; did you mean 'wind'"):
            make_plan(pendulum, TABLE, SweepOutput.model_validate({"labels": ["wind"]} | wrong))

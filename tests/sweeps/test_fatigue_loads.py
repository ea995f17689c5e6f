"""Damage-equivalent loads of the cases of a sweep: those of their histories, kept, read and summed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fixtures.swept_pendulum import TABLE
from pydantic import ValidationError
from sweeps.test_sweep import Here

from supple.cases import bodies, read_case
from supple.cases.result_tables import recorded_quantities
from supple.errors import CaseError
from supple.fatigue import Residue, damage_equivalent_load, rainflow
from supple.sweeps import CaseTable, FatigueLoads, read_sweep, read_sweep_file, sweep
from supple.sweeps.fatigue_loads import class_of, planned_channels, range_of, summed_spectra
from supple.sweeps.plan import SweepPlan
from supple.sweeps.read_sweep import SweepColumns
from supple.sweeps.sweep_file import SweepOutput
from supple.units import UnitSystem

LOADS = FatigueLoads(exponents=[4, 10], channels=["joint *"], reference_frequency=2.0, residue="closed")
NAMES = ["damage-equivalent range, m = 4", "damage-equivalent range, m = 10"]


@pytest.fixture
def swept(pendulum, tmp_path):
    folder = tmp_path / "out"
    sweep(pendulum, TABLE, folder, executor=Here(), keep="all", fatigue=LOADS)
    return folder


def test_loads_are_those_of_the_kept_histories(swept):
    columns, read = SweepColumns(swept), read_sweep(swept)
    assert list(read.statistic.values[-2:]) == NAMES
    assert "2 reference cycles per unit of time" in read.attrs["fatigue"]
    assert "residue as closed" in read.attrs["fatigue"]
    joint = np.array([name.startswith("joint ") for name in read.channel.values])
    for case in range(6):
        cycles = rainflow(columns.motion(case)["channels"], Residue.CLOSED)
        for name, exponent in zip(NAMES, (4, 10), strict=True):
            expected = damage_equivalent_load(cycles, exponent, 2.0 * 0.2).ranges
            found = read.statistics.sel(statistic=name).values[case]
            assert found[joint] == pytest.approx(expected[joint], rel=1e-12)
            assert np.isnan(found[~joint]).all()
    assert joint.sum() >= 3


def test_spectra_hold_the_cycles_of_all_cases(swept):
    columns = SweepColumns(swept)
    spectra = columns.spectra()
    assert spectra
    assert all(name.startswith("joint ") for name in spectra)
    name, (ranges, counts) = next(iter(spectra.items()))
    place = list(columns.channels["name"]).index(name)
    histories = np.stack([columns.motion(case)["channels"][:, place] for case in range(6)], axis=1)
    cycles = rainflow(histories, Residue.CLOSED)
    seen = cycles.ranges > 1e-3 * cycles.largest(cycles.ranges)[cycles.channels]
    assert counts.sum() == cycles.counts[seen].sum()
    assert np.all(np.diff(ranges) > 0)
    assert ranges[-1] == pytest.approx(cycles.ranges.max(), rel=0.06)


def test_classes_of_ranges():
    ranges = np.geomspace(1e-7, 1e9, 400)
    assert np.abs(np.log10(range_of(class_of(ranges)) / ranges)).max() <= 0.5 / 20 + 1e-9
    rows = np.array([[1, 5, 2.0], [0, -3, 1.0]])
    assert summed_spectra([rows, rows]).tolist() == [[0, -3, 2.0], [1, 5, 4.0]]
    assert summed_spectra([]).shape == (0, 3)


def test_without_them_nothing_is_added(pendulum, tmp_path):
    sweep(pendulum, CaseTable({"gravity[2]": [-9.81]}), tmp_path / "out", executor=Here())
    assert not SweepColumns(tmp_path / "out").spectra()
    assert "fatigue" not in read_sweep(tmp_path / "out").attrs


def test_a_name_that_matches_no_channel_is_refused_before_anything_runs(pendulum, tmp_path):
    loads = FatigueLoads(exponents=[4], channels=["joint *", "joint hing.*"])
    with pytest.raises(CaseError, match=r"no channel is named 'joint hing\.\*'; did you mean 'joint hinge"):
        sweep(pendulum, CaseTable({"gravity[2]": [-9.81]}), tmp_path / "out", executor=Here(), fatigue=loads)
    assert not (tmp_path / "out").exists()


def test_brackets_are_part_of_the_name_of_a_channel():
    times, values = np.arange(4.0), np.array([[0.0, 0.0], [1.0, 2.0], [0.0, 0.0], [1.0, 2.0]])
    for name in ("gauge[1]", "gau*[1]"):
        loads, _ = FatigueLoads(exponents=[4], channels=[name]).of(["gauge1", "gauge[1]"], times, values)
        # Three half cycles of range 2 in three units of time.
        assert loads[0] == pytest.approx([np.nan, 2.0 * 0.5**0.25], nan_ok=True)


def test_names_of_channels_are_known_before_bodies_are_reduced(case_folder, monkeypatch):
    case = read_case(case_folder / "strip.toml")
    names = [
        f"{quantity.name}.{channel.name}"
        for quantity in recorded_quantities(case, case.system)
        for channel in quantity.channels(case.system)
    ]
    assert any(name.startswith("deflection strip.") for name in names)
    monkeypatch.setattr(bodies, "reduce", None)
    assert planned_channels(read_case(case.path)) == tuple(names)


def test_the_table_of_the_file(pendulum, tmp_path):
    path = tmp_path / "cases.toml"
    path.write_text(
        f'case = "{pendulum.name}"\n[vary]\n"gravity[2]" = [-9.81]\n'
        '[output.fatigue]\nexponents = [4, 10]\nchannels = ["joint *"]\n'
        'residue = "closed"\nreference_frequency = 2.0\n'
    )
    assert read_sweep_file(path).output.fatigue == LOADS
    assert read_sweep_file(path).output.statistics[-2:] == tuple(NAMES)
    for wrong in (
        {"exponents": []},
        {"exponents": [4, 4.0]},
        {"exponents": [-1]},
        {"exponents": [4], "residue": "open"},
    ):
        with pytest.raises(ValidationError):
            FatigueLoads.model_validate(wrong)


def test_the_duration_of_a_case_is_counted_from_its_own_start():
    """Start times that vary between cases; the lifetime divides by end time less start time."""
    path, place = "simulation.start.time", ("simulation", "start", "time")
    whole = np.zeros(2, dtype=np.int64)
    plan = SweepPlan(
        case_file=Path("case.toml"),
        case_text='[simulation]\nstart = { file = "a.h5", time = 0.2 }\n',
        table=CaseTable({path: [0.2, 0.6]}),
        places={path: place},
        group=whole,
        share=whole,
        output=SweepOutput(),
        inputs={},
        units=UnitSystem(),
    )
    np.testing.assert_array_equal(plan.start_times, [0.2, 0.6])
    np.testing.assert_array_equal(replace(plan, places={}).start_times, [0.2, 0.2])

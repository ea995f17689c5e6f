"""A sweep is its cases simulated one by one: the same numbers, kept, found again and done once."""

from __future__ import annotations

import sys
from concurrent.futures import Future
from dataclasses import replace

import numpy as np
import pytest
from fixtures.swept_pendulum import TABLE
from scipy.integrate import solve_ivp

from supple.cases import read_case, run_case
from supple.errors import CaseError, ResultFileError, SuppleError
from supple.quantities import read_sensors
from supple.simulation import simulate
from supple.sweeps import (
    CaseTable,
    FatigueLoads,
    plan_sweep,
    read_sweep,
    sweep,
    sweep_status,
    swept_case,
    write_parquet,
)
from supple.sweeps.channel_statistics import STATISTICS, channel_statistics
from supple.sweeps.part_file import CaseStatus, part_path, read_part
from supple.sweeps.plan import changed_inputs, make_plan, read_plan
from supple.sweeps.read_sweep import SweepColumns
from supple.sweeps.run_share import run_cases
from supple.sweeps.sweep_file import SweepOutput


class Here:
    """An executor that runs tasks at once, in this process."""

    def __init__(self):
        self.tasks = 0

    def submit(self, task, *arguments):
        future = Future()
        self.tasks += 1
        try:
            future.set_result(task(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


def test_statistics_are_those_of_a_sine():
    times = np.linspace(0.0, 1.0, 1001)
    found = channel_statistics(times, np.stack([3.0 + 2.0 * np.sin(2 * np.pi * times), times], axis=1))
    by_name = dict(zip(STATISTICS, found[:, 0], strict=True))
    assert by_name["mean"] == pytest.approx(3.0, abs=1e-12)
    assert by_name["standard deviation"] == pytest.approx(np.sqrt(2.0), rel=1e-12)
    assert (by_name["minimum"], by_name["time of minimum"]) == pytest.approx((1.0, 0.75))
    assert (by_name["maximum"], by_name["time of maximum"]) == pytest.approx((5.0, 0.25))
    assert found[:, 1] == pytest.approx([0.5, 0.0, 1.0, 1 / np.sqrt(12), 0.0, 1.0], rel=1e-6)


def test_a_sweep_is_its_cases_one_by_one(pendulum, tmp_path):
    folder = tmp_path / "out"
    status = sweep(pendulum, TABLE, folder, executor=Here(), keep=[4])
    assert (status.n_ran, status.missing, status.failed, status.exit_code) == (6, (), (), 0)
    read = read_sweep(folder)
    for number in range(6):
        own = swept_case(folder, number)
        solution = simulate(own.system, own.run)
        columns = read_sensors(own.quantities, own.system, solution).columns()
        expected = channel_statistics(columns.times, columns.values)
        # Mapped over cases the program rounds otherwise: see the test below.
        assert np.abs(read.statistics[number].values.T - expected).max() < 1e-10 * np.abs(expected).max()
    assert list(read["body.bob.rigid.mass"].values) == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    tension = read.statistics.sel(channel="joint hinge.Fx")
    assert tension.unit == "N"
    # Every mass swings alike: forces are as the masses, but for the inertia about the centre, 0.1.
    angle = pendulum_angle(mass=3.0, gravity=4.0)
    kept = SweepColumns(folder).motion(4)
    assert kept["channels"].shape == (21, len(read.channel))
    bob = SweepColumns(folder).motion(4)["bodies/bob/position"]
    assert kept["times"][-1] == pytest.approx(0.2)
    assert np.arcsin(-bob[-1, 2]) == pytest.approx(pendulum_angle(mass=3.0, gravity=9.81), rel=1e-4)
    assert angle < pendulum_angle(mass=3.0, gravity=9.81)
    with pytest.raises(ResultFileError, match="has no motion of case 0"):
        SweepColumns(folder).motion(0)


@pytest.mark.slow
def test_the_distance_from_single_runs_is_round_off(pendulum, tmp_path):
    """A single run is as far from itself with a gravity of a few units in the last place more.

    Forces of joints hold the round-off of positions over `beta h^2`.
    """
    folder = tmp_path / "out"
    sweep(pendulum, TABLE, folder, executor=Here(), keep="all")
    for number in (0, 4):
        own = swept_case(folder, number)

        def alone(units, own=own):
            system = replace(
                own.system, gravity=np.array(own.system.gravity) * (1 + units * np.finfo(float).eps)
            )
            return read_sensors(own.quantities, system, simulate(system, own.run)).columns().values

        single = alone(0)
        spread = max(np.abs(alone(units) - single).max() for units in (1, 2, 5, 9))
        found = SweepColumns(folder).motion(number)["channels"]
        assert 0 < np.abs(found - single).max() < 10 * spread
        assert spread < 1e-10 * np.abs(single).max()


def pendulum_angle(mass, gravity):
    """Of the pendulum after 0.2 s: (0.1 + m) phi'' = m g cos(phi), to ten digits."""

    def rates(_, state):
        return [state[1], mass * gravity * np.cos(state[0]) / (0.1 + mass)]

    return solve_ivp(rates, (0.0, 0.2), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]


def test_the_same_call_does_what_is_missing_and_nothing_else(pendulum, tmp_path):
    folder, table = tmp_path / "out", CaseTable({"gravity[2]": np.linspace(-9.81, -1.0, 40).tolist()})
    sweep(pendulum, table, folder, executor=Here())
    assert read_plan(folder).n_shares == 3
    again = Here()
    sweep(pendulum, table, folder, executor=again)
    assert again.tasks == 0
    expected = read_sweep(folder).statistics.values
    whole = part_path(folder, 1).read_bytes()
    part_path(folder, 1).write_bytes(whole[:-200])
    part_path(folder, 2).unlink()
    assert sweep_status(folder).missing == (1, 2)
    assert sweep_status(folder).exit_code == 4
    assert np.isnan(read_sweep(folder).statistics.values[16:]).all()
    assert set(read_sweep(folder).cause.values[16:]) == {"not run yet"}
    sweep(pendulum, table, folder, executor=again)
    assert again.tasks == 2
    assert np.array_equal(read_sweep(folder).statistics.values, expected), "to the last bit"


class GivesUp(Here):
    """Cancels all tasks but the first, as the client of a cluster does whose scheduler is gone."""

    def submit(self, task, *arguments):
        if not self.tasks:
            return super().submit(task, *arguments)
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_tasks_that_are_given_up_are_an_error_and_missing(pendulum, tmp_path):
    table = CaseTable({"gravity[2]": np.linspace(-9.81, -1.0, 40).tolist()})
    with pytest.raises(
        SuppleError, match=r"lost its scheduler; .* the same command without force runs the missing cases"
    ):
        sweep(pendulum, table, tmp_path / "out", executor=GivesUp())
    assert sweep_status(tmp_path / "out").missing == (1, 2)


def test_a_sweep_of_other_inputs_is_refused(pendulum, tmp_path):
    folder, table = tmp_path / "out", CaseTable({"gravity[2]": [-9.81, -5.0]})
    sweep(pendulum, table, folder, executor=Here())
    with pytest.raises(ResultFileError, match=r"holds a sweep with other inputs \(the table"):
        sweep(pendulum, CaseTable({"gravity[2]": [-9.81, -6.0]}), folder, executor=Here())
    pendulum.write_text(pendulum.read_text().replace("step = 0.01", "step = 0.005"))
    with pytest.raises(ResultFileError, match=r"other inputs \(the case"):
        sweep(pendulum, table, folder, executor=Here())
    assert sweep(pendulum, table, folder, executor=Here(), force=True).n_ran == 2
    assert set(read_sweep(folder).steps.values) == {40}


@pytest.mark.parametrize("masses", [[1.0, -1.0, 2.0], [-1.0, 1.0, 2.0]])
def test_a_case_that_fails_is_recorded_and_the_others_go_on(pendulum, tmp_path, masses):
    """Also the first case of its group."""
    table = CaseTable({"body.bob.rigid.mass": masses})
    status = sweep(pendulum, table, tmp_path / "out", executor=Here())
    assert status.n_ran == 2
    assert status.exit_code == 3
    (failed,) = status.failed
    wrong = masses.index(-1.0)
    assert (failed.case, failed.status) == (wrong, CaseStatus.FAILED)
    assert "mass" in failed.cause
    read = read_sweep(tmp_path / "out")
    assert np.isnan(read.statistics.values[wrong]).all()
    assert np.isfinite(np.delete(read.statistics.values, wrong, axis=0)).all()


@pytest.mark.slow
def test_a_run_that_breaks_off_is_recorded_with_its_time_and_residual(pendulum, tmp_path):
    """A torque that turns the bob by more than digits hold: Newton's method does not converge, here alone."""
    text = pendulum.read_text() + (
        '\n[[load]]\nkind = "torque"\nat = "bob.pin"\nvector = [0.0, 1.0, 0.0]\n'
        'law = { kind = "ramp", value = 0.0, duration = 0.1 }\n'
    )
    pendulum.write_text(text)
    table = CaseTable({"load[0].law.value": [0.0, 1e40, 1.0]})
    status = sweep(pendulum, table, tmp_path / "out", executor=Here())
    (failed,) = status.failed
    assert failed.case == 1
    assert "t = " in failed.cause
    assert "residual" in failed.cause
    assert read_part(part_path(tmp_path / "out", 0)).results[1].end_time < 0.2


def test_cases_of_other_bodies_or_runs_are_groups_of_their_own(pendulum):
    table = CaseTable({"gravity[2]": [-1.0, -2.0, -3.0, -4.0], "simulation.duration": [0.2, 0.1, 0.2, 0.1]})
    plan = make_plan(pendulum, table, SweepOutput.model_validate({}))
    assert plan.group.tolist() == [0, 1, 0, 1]
    assert plan.share.tolist() == [0, 1, 0, 1]
    plan = make_plan(pendulum, CaseTable({"gravity[2]": [-1.0] * 3000}), SweepOutput.model_validate({}))
    sizes = np.bincount(plan.share)
    assert set(sizes[:-1]) == {48}
    assert sizes.sum() == 3000
    by_seven = SweepOutput.model_validate({"cases_per_share": 7})
    plan = make_plan(pendulum, CaseTable({"gravity[2]": [-1.0] * 20}), by_seven)
    assert np.bincount(plan.share).tolist() == [7, 7, 6]


def test_what_no_case_can_be_is_refused_before_anything_runs(pendulum, tmp_path):
    with pytest.raises(CaseError, match="no item is named 'bo'"):
        sweep(pendulum, {"body.bo.rigid.mass": [1.0]}, tmp_path / "out")
    with pytest.raises(CaseError, match=r"^joint.hinge.axsi: unknown key, did you mean 'axis'\?"):
        sweep(pendulum, {"gravity[2]": [-1.0], "joint.hinge.axsi": [[0, 1, 0]]}, tmp_path / "out")
    with pytest.raises(CaseError, match=r"^units.length: the units only name the numbers"):
        sweep(pendulum, {"units.length": ["m", "mm"]}, tmp_path / "out")
    with pytest.raises(CaseError, match="keep has case 7"):
        sweep(pendulum, {"gravity[2]": [-1.0]}, tmp_path / "out", keep=[7])
    for twice in (
        {"body.bob.rigid.mass": [1.0], "body[0].rigid.mass": [2.0]},
        {"gravity[2]": [1.0], "gravity": [[0, 0, 1]]},
    ):
        with pytest.raises(CaseError, match=r"replaces the value that .* varies: keep one of the columns"):
            sweep(pendulum, twice, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_sensor_that_cannot_be_built_is_refused_once(pendulum, tmp_path):
    sensor = '\n[[sensor]]\nname = "cut"\nkind = "section-force"\nat = "bob.pin"\nnormal = [1, 0, 0]\n'
    pendulum.write_text(pendulum.read_text() + sensor)
    with pytest.raises(CaseError, match=r"sensor\[1\]: sensor 'cut': body 'bob' is rigid"):
        sweep(pendulum, TABLE, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    plan = make_plan(pendulum, CaseTable({"sensor.cut.at": ["bob.pin"]}), SweepOutput())
    assert plan.n_cases == 1  # its sensors are those of its cases


def test_a_last_key_of_some_cases_is_no_mistake_of_the_plan(pendulum):
    """A sine has an amplitude, a ramp has none."""
    law = 'law = { kind = "ramp", value = 1.0, duration = 1.0 }'
    load = f'[[load]]\nkind = "force"\nat = "bob.pin"\nvector = [1.0, 0.0, 0.0]\n{law}\n\n[simulation]'
    pendulum.write_text(pendulum.read_text().replace("[simulation]", load))
    amplitudes = {"load[0].law.amplitude": [1.0, 2.0]}
    with pytest.raises(CaseError, match=r"load\[0\].law.amplitude: unknown key; known keys: kind"):
        make_plan(pendulum, CaseTable(amplitudes), SweepOutput())
    kinds = {"load[0].law.kind": ["ramp", "sine"], **amplitudes}
    assert make_plan(pendulum, CaseTable(kinds), SweepOutput()).n_cases == 2


def test_labels_have_no_names_of_results(pendulum, tmp_path):
    """All names in the data set besides paths are refused; a label `unit` replaced the units of channels."""
    fatigue = FatigueLoads(
        exponents=(4.0,), lifetime={"speed": "wind", "wind": {"scale": 9.6}, "duration": 1.0, "cut_in": 0.0}
    )
    table = {"gravity[2]": [-9.81, -4.0], "wind": [8.0, 12.0]}
    sweep(pendulum, table, tmp_path / "out", executor=Here(), labels=["wind"], fatigue=fatigue)
    names = {*map(str, read_sweep(tmp_path / "out").variables)} - table.keys()
    assert {"unit", "lifetime", "runs"} < names
    for name in names:
        with pytest.raises(
            CaseError, match=f"labels: '{name}' is the name of a result .*: rename the column"
        ):
            sweep(pendulum, {**table, name: [1, 2]}, tmp_path / "other", labels=["wind", name])


def test_cases_to_keep_are_numbers_or_a_word(pendulum, tmp_path):
    table = {"gravity[2]": [-9.81, -4.0]}
    sweep(pendulum, table, tmp_path / "out", executor=Here(), keep=np.arange(1, 2))
    assert len(SweepColumns(tmp_path / "out").motion(1)["times"]) == 21
    with pytest.raises(CaseError, match="keep: 'last' is not known; choose one of none, all"):
        sweep(pendulum, table, tmp_path / "other", keep="last")


def test_files_in_tables_of_a_column_are_inputs(pendulum, tmp_path):
    """A file that a whole table of a column names is an input, like a file in a column of texts."""
    load = '[[load]]\nkind = "force"\nat = "bob.pin"\nvector = [1.0, 0.0, 0.0]\n\n[simulation]'
    pendulum.write_text(pendulum.read_text().replace("[simulation]", load))
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("0,0\n1,1\n")
    laws = [{"kind": "table", "file": name} for name in ("a.csv", "b.csv")]
    first = make_plan(pendulum, CaseTable({"load[0].law": laws}), SweepOutput())
    (tmp_path / "b.csv").write_text("0,0\n1,2\n")
    now = make_plan(pendulum, CaseTable({"load[0].law": laws}), SweepOutput())
    assert changed_inputs(first, now) == "the file b.csv has changed"


def test_a_file_that_was_missing_is_a_changed_input(pendulum, tmp_path):
    """The case of the missing file fails; the same command must not keep it failed with the file there."""
    load = '[[load]]\nkind = "force"\nat = "bob.pin"\nvector = [1.0, 0.0, 0.0]\n\n[simulation]'
    pendulum.write_text(pendulum.read_text().replace("[simulation]", load))
    table = CaseTable({"load[0].law": [{"kind": "table", "file": name} for name in ("a.csv", "./b.csv")]})
    (tmp_path / "a.csv").write_text("0,0\n1,1\n")
    first = make_plan(pendulum, table, SweepOutput())
    assert not changed_inputs(first, make_plan(pendulum, table, SweepOutput()))
    (tmp_path / "b.csv").write_text("0,0\n1,1\n")
    now = make_plan(pendulum, table, SweepOutput())
    assert changed_inputs(first, now) == "the file b.csv has changed"


def test_a_case_with_a_changed_file_is_not_simulated_again(pendulum, tmp_path):
    """The second case has a file that the first case of its group does not read."""
    load = '[[load]]\nkind = "force"\nat = "bob.pin"\nvector = [1.0, 0.0, 0.0]\n\n[simulation]'
    pendulum.write_text(pendulum.read_text().replace("[simulation]", load))
    pendulum.write_text(
        pendulum.read_text().replace("\n\n[sim", '\nlaw = { kind = "table", file = "a.csv" }\n\n[sim')
    )
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("0,0\n1,1\n")
    table = CaseTable({"load[0].law.file": ["a.csv", "b.csv"]})
    plan_sweep(make_plan(pendulum, table, SweepOutput()), tmp_path / "out")
    (tmp_path / "b.csv").write_text("0,0\n1,2\n")
    assert swept_case(tmp_path / "out", 0).system.loads
    with pytest.raises(ResultFileError, match=r"planned with other files \(the file b.csv has changed\)"):
        swept_case(tmp_path / "out", 1)


def test_no_part_of_a_sweep_that_was_replaced_meanwhile_is_written(pendulum, tmp_path, monkeypatch):
    """A share that still runs when another table is planned in its folder is none of the new sweep."""
    folder, table = tmp_path / "out", CaseTable({"gravity[2]": [-9.81]})
    other = make_plan(pendulum, CaseTable({"gravity[2]": [-1.0]}), SweepOutput())

    def replaced(*given, **options):
        part = run_cases(*given, **options)
        plan_sweep(other, folder, force=True)
        return part

    monkeypatch.setattr(sys.modules[run_cases.__module__], "run_cases", replaced)
    with pytest.raises(ResultFileError, match=r"another sweep was planned here .*\(the table has changed\)"):
        sweep(pendulum, table, folder, executor=Here())
    assert sweep_status(folder).missing == (0,)


def test_the_table_of_a_case_file_is_that_of_its_own_run(pendulum, tmp_path):
    """The case in the middle has the file's own mass: what it reads is what the file's own run reads."""
    sweep(pendulum, {"body.bob.rigid.mass": [1.0, 2.0]}, tmp_path / "out", executor=Here())
    case = read_case(pendulum)
    solution = simulate(case.system, case.run)
    force = read_sweep(tmp_path / "out").statistics.sel(channel="joint hinge.Fz", statistic="maximum")[1]
    assert float(force) == pytest.approx(solution.joint_forces["hinge"][:, 2].max(), rel=1e-12)


def test_a_parquet_file_has_a_row_a_case(pendulum, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    sweep(pendulum, TABLE, tmp_path / "out", executor=Here())
    read = read_sweep(tmp_path / "out")
    write_parquet(read, tmp_path / "cases.parquet")
    table = parquet.read_table(tmp_path / "cases.parquet")
    assert table.num_rows == 6
    assert table["gravity[2]"].to_pylist() == list(TABLE.columns["gravity[2]"])
    for statistic in ("mean", "time of maximum"):
        expected = read.statistics.sel(channel="joint hinge.Fx", statistic=statistic).values
        assert np.array_equal(table[f"joint hinge.Fx {statistic}"].to_numpy(), expected)


def test_files_that_a_machine_file_includes_are_inputs(tmp_path):
    """A changed mass in an included file is a changed input of the sweep, as in a run."""
    pytest.importorskip("mujoco")
    body = '<mujoco><worldbody><body name="a"><joint name="hip" type="hinge" axis="0 1 0"/>'
    inertial = '<inertial pos="1 0 0" mass="{}" diaginertia="1 1 1"/></body></worldbody></mujoco>'
    (tmp_path / "arm.xml").write_text('<mujoco><include file="body.xml"/></mujoco>')
    (tmp_path / "body.xml").write_text(body + inertial.format(2))
    path = tmp_path / "arm.toml"
    run = "[simulation]\nduration = 0.1\noutput_step = 0.05\nstep = 0.05\n"
    path.write_text('title = "arm"\nbody = []\n[machine]\nmujoco = "arm.xml"\n' + run)
    table = CaseTable({"gravity[2]": [-9.81, -1.0]})
    first = make_plan(path, table, SweepOutput())
    assert not changed_inputs(first, make_plan(path, table, SweepOutput()))
    (tmp_path / "body.xml").write_text(body + inertial.format(3))
    assert "the machine" in changed_inputs(first, make_plan(path, table, SweepOutput()))


def test_cases_that_start_at_different_times_have_the_durations_of_their_runs(pendulum, tmp_path):
    run_case(read_case(pendulum), tmp_path / "before", errors=False)
    start = 'step = 0.01\nstart = { file = "before/pendulum.h5", time = 0.05 }'
    pendulum.write_text(pendulum.read_text().replace("\nstep = 0.01", "\n" + start))
    sweep(pendulum, CaseTable({"simulation.start.time": [0.0, 0.05, 0.1]}), tmp_path / "out", executor=Here())
    columns = SweepColumns(tmp_path / "out")
    assert columns.of_cases("end_time") - columns.plan.start_times == pytest.approx([0.2, 0.2, 0.2])

"""Controllers in a sweep: their file runs where the command allows it, and in no other task."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from supple.cli.main import app
from supple.errors import CaseError, ResultFileError
from supple.sweeps import make_plan, plan_sweep, read_sweep, run_part_of_sweep, sweep_status, swept_case
from supple.sweeps.case_table import CaseTable
from supple.sweeps.run_share import run_share
from supple.sweeps.sweep_file import SweepOutput

CONTROLLER = """\
from pathlib import Path

from supple import machine as m

(Path(__file__).parent / "ran").touch()


def outputs(t, reads, z):
    return {"motor": -20 * reads["hinge"].angle - 3 * reads["hinge"].rate}


def driven(outputs):
    return m.Controller(
        reads={"hinge": m.JointReading("hinge")},
        drives={"motor": m.TorqueBetween(first="ground", second="bob.pin", axis=(0, 1, 0))},
        outputs=outputs,
    )


def held(system):
    return driven(outputs)


def anew(system):
    return driven(lambda t, reads, z: {"motor": -20 * reads["hinge"].angle})
"""
TABLE = CaseTable({"gravity[2]": [-9.81, -4.0]})


@pytest.fixture
def controlled(pendulum, tmp_path):
    """The pendulum with a motor that holds it."""
    (tmp_path / "controller.py").write_text(CONTROLLER)
    pendulum.write_text('control = "controller.py:held"\n' + pendulum.read_text())
    return pendulum


def planned(case, folder, **allowed):
    plan_sweep(make_plan(case, TABLE, SweepOutput.model_validate({}), **allowed), folder)
    return folder


def test_code_runs_where_it_is_allowed_and_nowhere_else(controlled, tmp_path):
    with pytest.raises(CaseError, match="--allow-code"):
        planned(controlled, tmp_path / "out")
    (tmp_path / "cases.toml").write_text('case = "pendulum.toml"\n[vary]\n"gravity[2]" = [-9.81, -4.0]\n')
    words = ["sweep", str(tmp_path / "cases.toml"), "-o", str(tmp_path / "out")]
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2
    assert "--allow-code" in refused.output
    folder = planned(controlled, tmp_path / "out", allow_code=True)
    # A plan gives no permission: whoever is handed the folder must give it again.
    run_share(str(folder), 0)
    assert [each.cause for each in sweep_status(folder).failed if "--allow-code" in each.cause]
    assert not (tmp_path / "ran").exists()


def test_cases_with_a_controller_swing_as_its_law_has_it(controlled, tmp_path):
    folder = planned(controlled, tmp_path / "out", allow_code=True)
    run_part_of_sweep(folder, 1, 1, allow_code=True)
    read = read_sweep(folder)
    assert sweep_status(folder).n_ran == 2
    assert np.isnan(read.estimated_error.values).all()
    smallest = read.statistics.sel(channel="joint hinge.Fx", statistic="minimum").values
    assert smallest == pytest.approx([smallest_force(9.81), smallest_force(4.0)], rel=2e-3)
    with pytest.raises(CaseError, match="--allow-code"):
        swept_case(folder, 0)
    first, second = (swept_case(folder, number, allow_code=True).system for number in (0, 1))
    assert first.controllers[0].outputs is second.controllers[0].outputs


def smallest_force(gravity):
    """Of the hinge along x: `m r (-a'' sin a - a'^2 cos a)` for the angle a of the bob below the level."""

    def acceleration(angle, rate):
        return (2.0 * gravity * np.cos(angle) - 20 * angle - 3 * rate) / (0.1 + 2.0)

    times = np.linspace(0.0, 0.2, 21)
    found = solve_ivp(
        lambda _, y: (y[1], acceleration(*y)), (0.0, 0.2), (0.0, 0.0), t_eval=times, rtol=1e-10, atol=1e-12
    )
    angle, rate = found.y
    return float(np.min(-2.0 * (acceleration(angle, rate) * np.sin(angle) + rate**2 * np.cos(angle))))


def test_functions_made_anew_for_each_case_are_refused(controlled, tmp_path):
    controlled.write_text(controlled.read_text().replace("py:held", "py:anew"))
    folder = planned(controlled, tmp_path / "out", allow_code=True)
    run_part_of_sweep(folder, 1, 1, allow_code=True)
    assert all("creates new functions at every call" in each.cause for each in sweep_status(folder).failed)
    assert sweep_status(folder).n_ran == 0


def test_another_file_than_was_planned_does_not_run(controlled, tmp_path):
    folder = planned(controlled, tmp_path / "out", allow_code=True)
    (tmp_path / "controller.py").write_text(CONTROLLER + "1 / 0\n")
    with pytest.raises(ResultFileError, match="planned with other files"):
        run_share(str(folder), 0, True)

"""Bodies of a sweep: reduced once for all that does not change them, damped as each case asks."""

from __future__ import annotations

import re

import numpy as np
import pytest
from fixtures.bar_of_every_form import LIFT, RUN, write_case

from supple.cases import read_case
from supple.simulation import simulate
from supple.sweeps import CaseTable, full_factorial, read_sweep, sweep
from supple.sweeps.plan import make_plan
from supple.sweeps.sweep_file import SweepOutput


@pytest.fixture
def strip_case(case_folder):
    """The clamped strip for ten steps, two modes and a short name of its tip's deflection."""
    path = case_folder / "strip.toml"
    text = path.read_text().replace("duration = 0.4", "duration = 0.02").replace("modes = 4", "modes = 2")
    path.write_text(text.replace('damping = { kind = "rayleigh", alpha = 0.0, beta = 0.02 }', DAMPING))
    return path


DAMPING = 'damping = { kind = "rayleigh-ratio", ratio = 0.02, held = "root" }'
TIP = "deflection strip.TIP.z"


def test_damping_speed_and_loads_share_a_body_and_thickness_does_not(strip_case):
    table = full_factorial(
        {
            "body.strip.shell.thickness": [0.01, 0.012, 0.014],
            "body.strip.damping.ratio": [0.0, 0.02, 0.05],
            "gravity[2]": [-9.81, -5.0, -1.0],
        }
    )
    plan = make_plan(strip_case, table, SweepOutput.model_validate({}))
    assert plan.group.tolist() == [0] * 9 + [1] * 9 + [2] * 9
    # Reduced with the most damping of the group, from which the others are scaled.
    assert [plan.representatives(group)[0] for group in range(3)] == [6, 15, 24]


def test_a_case_whose_trial_runs_determine_its_modes_shares_no_body(tmp_path):
    """The first case, with a small load, would determine the modes of a case with a large one."""
    path = write_case(tmp_path, "intrinsic", LIFT, RUN)
    table = CaseTable({"load[0].vector": [[0.0, 0.0, 1e-3], [0.0, 0.0, 60.0]]})
    for more, groups in (("modes = 12", [0, 0]), ("accuracy = {}", [0, 1])):
        path.write_text(re.sub(r"released = true.*}", f"released = true, {more} }}", path.read_text()))
        assert make_plan(path, table, SweepOutput.model_validate({})).group.tolist() == groups


def test_damping_of_several_bodies_is_never_scaled_from_none(strip_case):
    """The first case has the largest ratio of one body and none of the other: the second needs its own."""
    text = strip_case.read_text()
    body = text[text.index("[[body]]") : text.index("[[joint]]")].replace('"strip"', '"other"', 1)
    strip_case.write_text(text.replace("[[joint]]", body + "[[joint]]", 1))
    table = CaseTable(
        {
            "body.strip.damping.ratio": [0.05, 0.02, 0.01, 0.0],
            "body.other.damping.ratio": [0.0, 0.03, 0.02, 0.0],
        }
    )
    plan = make_plan(strip_case, table, SweepOutput.model_validate({}))
    assert plan.group.tolist() == [0, 1, 1, 2]
    assert [plan.representatives(group)[0] for group in range(3)] == [0, 1, 3]


@pytest.mark.parametrize("held", [pytest.param('held = "root"', marks=pytest.mark.slow), "modes = [1, 3]"])
def test_a_case_is_that_of_a_file_with_its_damping(strip_case, tmp_path, held, monkeypatch):
    """The second ratio is scaled from the reduction with the first; alone its body is reduced with it."""
    from concurrent.futures import ThreadPoolExecutor

    strip_case.write_text(strip_case.read_text().replace('held = "root"', held))
    table = CaseTable({"body.strip.damping.ratio": [0.2, 0.02]})
    with ThreadPoolExecutor(1) as executor:
        assert sweep(strip_case, table, tmp_path / "out", executor=executor).n_ran == 2
    assert len(list((tmp_path / "out" / "bodies").iterdir())) == 1
    read = read_sweep(tmp_path / "out").statistics.sel(channel=TIP, statistic="minimum")
    case = read_case(strip_case)
    solution = simulate(case.system, case.run)
    place = case.place("strip.TIP")
    from supple.quantities import DeflectionSensor

    alone = DeflectionSensor("tip", place).values(case.system, solution)[:, 2].min()
    assert float(read[1]) == pytest.approx(alone, rel=1e-9)
    assert abs(float(read[0]) / alone - 1) > 1e-4, "damping shows"


@pytest.mark.slow
def test_other_damping_finds_its_body_again(strip_case, tmp_path, monkeypatch):
    """A sweep begun anew, and a second one in the same folder, reduce nothing."""
    from concurrent.futures import ThreadPoolExecutor

    from supple.sweeps import group_bodies

    table = CaseTable({"gravity[2]": [-9.81, -5.0]})
    with ThreadPoolExecutor(1) as executor:
        sweep(strip_case, table, tmp_path / "out", executor=executor)
        first = read_sweep(tmp_path / "out").statistics.values
        monkeypatch.setattr(group_bodies, "_reduce", None)
        sweep(strip_case, table, tmp_path / "out", executor=executor, force=True)
    assert np.array_equal(read_sweep(tmp_path / "out").statistics.values, first)

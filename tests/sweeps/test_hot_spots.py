"""Hot spots and lifetimes of a sweep: those of the functions of `supple.fatigue`, on the motions kept."""

import numpy as np
import pytest

from supple.cases import read_case
from supple.errors import CaseError, ModelError
from supple.fatigue import Goodman, SNCurve, ThicknessEffect, Weibull, lifetime_of_cases
from supple.quantities import SignedVonMises, hot_spot_damage, stress_modes
from supple.reduction import ReducedBody
from supple.sweeps import CaseTable, make_plan, plan_sweep, read_sweep, sweep_status, swept_case
from supple.sweeps.part_file import CaseStatus
from supple.sweeps.read_sweep import SweepColumns
from supple.sweeps.run_share import run_share
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.sweep_report import write_sweep_report

TABLE = CaseTable({"gravity[2]": [-9.81, -30.0, -5.0], "wind": [8.0, 12.0, 8.0]})
CURVE = {"reference_range": 5e6, "reference_cycles": 1e3, "exponent": 3.0, "exponent_beyond": 5.0}
SPOT = {"name": "weld", "nodes": "strip.ROOT", "curve": CURVE, "criterion": {"kind": "signed-von-mises"}}
LIFETIME = {"speed": "wind", "wind": {"scale": 9.0}, "duration": 6.3e8, "cut_in": 4.0, "cut_out": 25.0}
FATIGUE = {
    "exponents": [4],
    "channels": ["deflection *"],
    "reference_frequency": 2.0,
    "hot_spot": [SPOT],
    "lifetime": LIFETIME,
}


@pytest.fixture
def strip(case_folder):
    path = case_folder / "strip.toml"
    text = path.read_text().replace("duration = 0.4", "duration = 0.1").replace("modes = 4", "modes = 2")
    path.write_text(text)
    return path


def output(**changed):
    return SweepOutput.model_validate({"keep": "all", "labels": ["wind"], "fatigue": FATIGUE | changed})


def swept(strip, folder, **changed):
    plan_sweep(make_plan(strip, TABLE, output(**changed)), folder)
    run_share(str(folder), 0)
    return folder


def test_damage_and_lifetime_are_those_of_the_kept_motions(strip, tmp_path):
    folder = swept(strip, tmp_path / "out")
    assert sweep_status(folder).n_ran == 3
    read, columns = read_sweep(folder), SweepColumns(folder)
    case = read_case(strip)
    nodes = case.meshes["strip"].nodes_of("ROOT")
    names = [f"weld.{number}" for number in case.meshes["strip"].node_ids[nodes]]
    assert read.channel.values[-len(names) :].tolist() == names
    own = swept_case(folder, 0)
    modes = stress_modes(own.system.bodies_of(ReducedBody)["strip"], case.elements["strip"], nodes)
    curve = SNCurve(5e6, 1e3, 3.0, 5.0)
    damage = read.statistics.sel(channel=names, statistic="damage").values
    for number in range(3):
        coordinates = columns.motion(number)["bodies/strip/coordinates"]
        expected = hot_spot_damage(modes, coordinates, curve, SignedVonMises())
        np.testing.assert_allclose(damage[number], expected, rtol=1e-10)
    assert damage.max() > 1e-6
    assert np.isnan(read.statistics.sel(channel=names, statistic="mean").values).all()
    assert np.isnan(read.statistics.sel(channel="deflection strip.TIP.z", statistic="damage").values).all()

    life = lifetime_of_cases([8.0, 12.0, 8.0], 0.1, Weibull(9.0), 6.3e8, 4.0, 25.0)
    np.testing.assert_allclose(
        read.lifetime.sel(channel=names, fatigue="damage"), life.damage(damage), rtol=1e-12
    )
    name = "damage-equivalent range, m = 4"
    loads = read.statistics.sel(channel="deflection strip.TIP.z", statistic=name).values
    found = float(read.lifetime.sel(channel="deflection strip.TIP.z", fatigue=name))
    assert found == pytest.approx(float(life.equivalent_load(loads, 4, 2.0 * 0.1, 1e7)), rel=1e-12)
    page = write_sweep_report(folder).read_text()
    assert "weld." in page
    assert "Lifetime" in page
    assert f"{found:.4g}" in page


@pytest.mark.slow
def test_a_peak_beyond_the_ultimate_stress_is_a_failure_of_its_case_alone(strip, tmp_path):
    own = swept_case(swept(strip, tmp_path / "first"), 1)
    case = read_case(strip)
    nodes = case.meshes["strip"].nodes_of("ROOT")
    modes = stress_modes(own.system.bodies_of(ReducedBody)["strip"], case.elements["strip"], nodes)
    peaks = [
        modes.von_mises(SweepColumns(tmp_path / "first").motion(number)["bodies/strip/coordinates"]).max()
        for number in range(3)
    ]
    ultimate = float(np.sqrt(peaks[0] * peaks[1]))
    folder = swept(strip, tmp_path / "out", hot_spot=[SPOT | {"ultimate": ultimate}])
    (failed,) = sweep_status(folder).failed
    assert (failed.case, failed.status) == (1, CaseStatus.FAILED)
    assert "ultimate" in failed.cause
    read = read_sweep(folder)
    assert np.isnan(read.lifetime.values).all(), "no lifetime without all cases"
    assert np.isfinite(read.statistics.sel(statistic="damage").values[[0, 2], -1]).all()
    assert "loads and damage of the lifetime need all cases" in write_sweep_report(folder).read_text()
    with pytest.raises(ModelError):
        Goodman(-1.0)


def test_what_is_not_there_is_refused_before_anything_runs(strip):
    def refused(words, error=CaseError, **changed):
        with pytest.raises(error, match=words):
            make_plan(strip, TABLE, output(**changed))

    refused("no body 'stirp' that is reduced .* mean 'strip'", hot_spot=[SPOT | {"nodes": "stirp.ROOT"}])
    refused("hot spot 'weld': no node set 'ROTO'", hot_spot=[SPOT | {"nodes": "strip.ROTO"}])
    refused("is given twice", hot_spot=[SPOT, SPOT])
    refused("no column is named 'wnd'; did you mean 'wind'", lifetime=LIFETIME | {"speed": "wnd"})
    refused("beyond cut_in", ModelError, lifetime=LIFETIME | {"cut_in": 9.0})


def test_the_plan_keeps_its_tables(strip, tmp_path):
    """Read back, the output is what it was: choices among tables among it."""
    thick = CURVE | {"thickness": {"thickness": 0.04, "reference": 0.025, "exponent": 0.2}}
    made = output(hot_spot=[SPOT | {"curve": thick}])
    (spot,) = SweepOutput.model_validate_json(made.model_dump_json()).fatigue.hot_spot
    assert spot.criterion.build() == SignedVonMises()
    assert spot.curve.build().thickness == ThicknessEffect(0.04, 0.025, 0.2)
    assert made.statistics[-2:] == ("damage-equivalent range, m = 4", "damage")

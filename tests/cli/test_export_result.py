"""`supple export` of a result: the machine comes from the case file, the motion from the result."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from fixtures.strip_case import filled
from scipy.io import loadmat
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cases.modes_case import mode_case
from supple.cases.result_machine import CASE_FILE, path_from, result_machine
from supple.cli.main import app
from supple.errors import ResultFileError
from supple.importers import read_mesh
from supple.integrate import FloatingMotion, Solution, Statistics
from supple.simulation.recorded_columns import columns_of
from supple.simulation.stored_bodies import store_bodies
from supple.storage import write_reduced_body, write_solution

UNITS = 'units = { length = "m", mass = "kg", time = "s" }\n'
SENSOR = """
[[sensor]]
name = "tip"
kind = "position"
at = "strip.TIP"
"""


def exported(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


@pytest.fixture(scope="module")
def exported_case(tmp_path_factory):
    """A folder with the strip's case, in units, and in `results` a motion of it that is made up."""
    own = filled(tmp_path_factory.mktemp("case"))
    path = own / "strip.toml"
    path.write_text(UNITS + path.read_text())
    case, folder = read_case(path), own / "results"
    times = np.linspace(0, 0.4, 11)
    r = case.system.bodies[0].body.n_coordinates
    still = np.zeros((11, 3))
    coordinates = 1e-3 * np.outer(np.sin(10 * times), np.arange(1, r + 1))
    frame, rates = (still, np.tile(np.eye(3), (11, 1, 1))), 0 * coordinates
    motion = FloatingMotion(*frame, coordinates, still, still, rates, still, still, rates)
    forces = np.column_stack([times, *[2 * times] * 5])
    solution = Solution(times, {"strip": motion}, {"clamp": forces}, Statistics())
    store_bodies(case.system, case.made_here, folder)
    metadata = {CASE_FILE: path_from(folder, path), "units": str(case.units), **columns_of(case.system)}
    write_solution(folder / "strip.h5", solution, case=case.text, metadata=metadata, inputs=case.inputs)
    return own


@pytest.fixture
def result(exported_case, case_folder):
    """The result of a case, both in a folder of their own."""
    shutil.copytree(exported_case, case_folder, dirs_exist_ok=True)
    return case_folder / "results" / "strip.h5"


def test_a_table_has_sensors_forces_places_and_energies(result, case_folder, tmp_path):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text() + SENSOR)  # a sensor may be added afterwards
    done = exported(result, "-o", tmp_path / "a.csv")
    assert done.exit_code == 0, done.output
    assert "11 instants written to" in done.output
    with (tmp_path / "a.csv").open(newline="") as file:
        heads, *rows = csv.reader(file)
    table = dict(zip(heads, np.array(rows, dtype=float).T, strict=True))
    assert heads[:5] == ["Time_[s]", "tip.x_[m]", "tip.y_[m]", "tip.z_[m]", "joint clamp.Fx_[N]"]
    assert heads[-4:] == [f"energy.{each}_[J]" for each in ("kinetic", "strain", "potential", "total")]
    np.testing.assert_allclose(table["joint clamp.Mz_[N m]"], 2 * table["Time_[s]"])
    np.testing.assert_allclose(table["position strip.TIP.z_[m]"], table["tip.z_[m]"], rtol=1e-12)
    found = result_machine(result)
    (part,) = found.run
    body = found.system.bodies[0].body
    tip = body.positions(part.bodies["strip"], found.case.place("strip.TIP").at).mean(axis=1)
    np.testing.assert_allclose(table["tip.z_[m]"], tip[:, 2], atol=1e-15)
    assert abs(table["deflection strip.TIP.z_[m]"]).max() > 1e-4


@pytest.mark.slow
def test_chosen_instants_and_other_tables(result, tmp_path):
    done = exported(result, "-o", tmp_path / "a.mat", "--times", "0.08:0.32:3")
    assert done.exit_code == 0, done.output
    np.testing.assert_allclose(loadmat(tmp_path / "a.mat")["time"][:, 0], [0.08, 0.2, 0.32])
    assert exported(result, "-o", tmp_path / "a.outb").exit_code == 0
    assert (tmp_path / "a.outb").read_bytes()[:2] == b"\x04\x00"


def test_paraview_files(result, case_folder, tmp_path):
    done = exported(result, "-o", tmp_path / "a.vtkhdf", "--body", "strip")
    assert done.exit_code == 0, done.output
    done = exported(result, "-o", tmp_path / "a.vtu", "--body", "strip", "--time", 0.2, "--no-stress")
    assert done.exit_code == 0, done.output
    assert "t = 0.2 s written" in done.output
    mesh, again = read_mesh(case_folder / "strip.inp"), read_mesh(tmp_path / "a.vtu")
    np.testing.assert_allclose(again.nodes, mesh.nodes, atol=1e-15)
    assert {kind: len(cells) for kind, cells in again.cells.items()} == {
        kind: len(cells) for kind, cells in mesh.cells.items()
    }


@pytest.mark.slow
def test_a_result_is_found_again_where_both_were_moved_to(result, case_folder, tmp_path):
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for name in ("strip.toml", "strip.inp"):
        (case_folder / name).rename(moved / name)
    shutil.move(result.parent, moved / "results")
    assert exported(moved / "results" / "strip.h5", "-o", tmp_path / "a.csv").exit_code == 0
    shutil.move(moved / "results", tmp_path / "far")
    lost = exported(tmp_path / "far" / "strip.h5", "-o", tmp_path / "a.csv")
    assert lost.exit_code == 2
    assert "--case FILE" in lost.output
    given = exported(tmp_path / "far" / "strip.h5", "-o", tmp_path / "a.csv", "--case", moved / "strip.toml")
    assert given.exit_code == 0, given.output


def test_a_case_that_changed_is_refused(result, case_folder):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace("thickness = 0.01", "thickness = 0.02"))
    with pytest.raises(ResultFileError, match=r"thickness was 0\.01 and is 0\.02"):
        result_machine(result)


def test_keys_that_a_later_supple_adds_do_not_matter_but_files_do(result, case_folder, monkeypatch):
    with monkeypatch.context() as newer:
        inputs = read_case(case_folder / "strip.toml").inputs
        newer.setattr(type(read_case(case_folder / "strip.toml")), "inputs", dict(inputs) | {"new": "1"})
        result_machine(result)
    mesh = case_folder / "strip.inp"
    mesh.write_text(mesh.read_text() + "** another line\n")
    with pytest.raises(ResultFileError, match=r"the file strip\.inp has changed"):
        result_machine(result)


def test_reduced_bodies_of_another_run_are_refused(result):
    case = read_case(result.parents[1] / "strip.toml")
    body = case.system.bodies[0].body
    write_reduced_body(result.parent / "strip-reduced.h5", replace(body, nodal_basis=-body.nodal_basis))
    with pytest.raises(ResultFileError, match="columns that are not those of the given body"):
        result_machine(result)
    (result.parent / "strip-reduced.h5").unlink()
    with pytest.raises(ResultFileError, match=r"strip-reduced.h5 is missing"):
        result_machine(result)


@pytest.mark.parametrize("name", ["strip.h5", "strip-reduced.h5"])
def test_the_files_of_the_result_are_not_written_over(result, name):
    before = (result.parent / name).read_bytes()
    done = exported(result, "-o", result.parent / name)
    assert done.exit_code == 2
    assert "it is the result itself" in " ".join(done.output.split())
    assert (result.parent / name).read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "cause"),
    [
        (("a.xls",), "a file that ends in .vtkhdf, .vtu, .csv"),
        (("a.csv", "--body", "strip"), "--body is not for a table of the whole machine: remove it"),
        (("a.csv", "--time", "0.1"), "--time is not for a table of the whole machine"),
        (("a.vtu", "--times", "0:1:3"), "--times is not for a .vtu, which contains one time"),
        (("a.csv", "--fmi", "2", "--allow-code"), "--fmi and --allow-code are not for a table"),
        (("a.csv", "--times", "0:1"), "must be FROM:TO:NUMBER"),
        (("a.csv", "--times", "0:0.4:0"), "with a NUMBER of at least 1"),
        (("a.csv", "--times", "0:1:3"), "no output at 0.5: give times from 0 to 0.4"),
        (("a.vtu", "--time", "-1"), "no output at -1"),
        (("a.vtu", "--time", "nan"), "no output at nan"),
        (("a.vtkhdf", "--body", "strap"), "did you mean 'strip'"),
        (("a.csv", "--abaqus"), "--abaqus is not for a table"),
    ],
)
def test_mistakes_are_named(result, tmp_path, arguments, cause):
    name, *options = arguments
    done = exported(result, "-o", tmp_path / name, *options)
    assert done.exit_code == 2, done.output
    assert cause in " ".join(done.output.split())
    assert not (tmp_path / name).exists()


@pytest.mark.slow
def test_a_mode_is_written_as_a_motion(case_folder, tmp_path):
    """One period of it, as pictures have it."""
    for name in ("a.vtkhdf", "a.vtu"):
        done = exported(case_folder / "strip.toml", "-o", tmp_path / name, "--mode", 1, "--body", "strip")
        assert done.exit_code == 0, done.output
    system, motion = mode_case(read_case(case_folder / "strip.toml"), 1, time=0.0)
    positions = system.bodies[0].body.positions(motion.bodies["strip"])
    with h5py.File(tmp_path / "a.vtkhdf") as file:
        points, moved = (file[f"VTKHDF/{name}"][()] for name in ("Points", "PointData/displacement"))
    assert abs(moved).max() > 0.02
    np.testing.assert_allclose(points + moved.reshape(24, -1, 3), positions, atol=1e-7)
    assert read_mesh(tmp_path / "a.vtu").n_cells
    wrong = exported(case_folder / "strip.toml", "-o", tmp_path / "a.csv", "--mode", 1)
    assert "--mode needs a case" in wrong.output


def test_options_of_results_are_refused_for_cases(case_folder, tmp_path):
    done = exported(case_folder / "strip.toml", "-o", tmp_path / "a.inp", "--times", "0:1:3")
    assert done.exit_code == 2
    assert "--times is not for the deck of a case's body" in " ".join(done.output.split())


def test_chosen_instants_of_an_angle_count_the_turns_between_and_before_them(tmp_path):
    """A wheel at 40 rad/s: more than three turns between the instants, and six before the first."""
    case = tmp_path / "wheel.toml"
    case.write_text(
        f'title = "wheel"\n{UNITS}[[body]]\nname = "wheel"\n'
        "rigid = { mass = 1.0, centre = [0, 0, 0], inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }\n"
        '[[body.interface]]\nname = "hub"\nposition = [0, 0, 0]\n'
        '[[joint]]\nname = "drive"\nkind = "prescribed-rotation"\nfirst = "ground"\nsecond = "wheel.hub"\n'
        'axis = [0, 0, 1]\nlaw = { kind = "constant-rate", rate = 40.0 }\n'
        '[[sensor]]\nname = "azimuth"\nkind = "joint-motion"\njoint = "drive"\n'
        "[simulation]\nduration = 2.0\noutput_step = 0.05\nstep = 0.05\nkinematic = true\n"
        "[output]\npictures = false\nreport = false\n"
    )
    done = CliRunner().invoke(app, ["run", str(case), "-o", str(tmp_path / "results")])
    assert done.exit_code == 0, done.output
    result = tmp_path / "results" / "wheel.h5"
    assert exported(result, "-o", tmp_path / "a.csv", "--times", "1:2:3").exit_code == 0
    with (tmp_path / "a.csv").open(newline="") as file:
        heads, *rows = csv.reader(file)
    table = dict(zip(heads, np.array(rows, dtype=float).T, strict=True))
    np.testing.assert_allclose(table["azimuth.angle_[rad]"], [40.0, 60.0, 80.0], rtol=1e-9)
    np.testing.assert_allclose(table["azimuth.rate_[rad/s]"], 40.0, rtol=1e-9)


@pytest.mark.slow
def test_a_split_body_is_pictured_by_its_own_name(case_folder, tmp_path):
    case, file = case_folder / "strip.toml", tmp_path / "mode.vtu"
    case.write_text(case.read_text().replace("damping =", "split = { parts = 2 }\ndamping =", 1))
    done = exported(case, "-o", file, "--mode", "1", "--body", "strip")
    assert done.exit_code == 0, done.output
    assert [read_mesh(file, only=f"body_{k}").n_nodes for k in (0, 1)] == [15, 15]

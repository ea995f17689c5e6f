"""The commands as a user types them: what they print, what they write, and how they fail."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
from fixtures.strip_case import filled
from typer.testing import CliRunner

from supple import __version__
from supple.cases import read_case
from supple.cases.body_kinds import Shell
from supple.cli.main import app
from supple.fem import LaminateSection, shell_model
from supple.importers import read_mesh
from supple.storage import ResultFile, read_header, read_solution

ROOT_WEIGHT = 7850.0 * 1.0 * 0.1 * 0.01 * 9.81


def call(*arguments, code=0):
    """Output of a command (errors included), its lines joined so that wrapping does not matter."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", result.output)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A folder whose case has run, with results in `out`, and what the run printed."""
    folder = filled(tmp_path_factory.mktemp("finished"))
    case = folder / "strip.toml"
    case.write_text('units = { time = "s" }\n' + case.read_text())
    return folder, call("run", case, "-o", folder / "out", "--no-errors")


@pytest.mark.parametrize("command", ["run", "reduce", "static", "modes", "export", "info", "check"])
def test_help_is_plain(command):
    """Flags stand alone, without a type that one would have to give; no markup takes words away."""
    found = call(command, "--help")
    assert "--debug Show the whole traceback" in found
    for styled in ("bool", "BOOLEAN", "case's ,", "has a ."):
        assert styled not in found


def test_run_writes_results_and_prints_tables(finished):
    folder, output = finished
    for part in (
        "clamped strip",
        "Bodies",
        "Joints",
        "Tracked motion",
        "strip.TIP",
        "Newton iterations",
        "Results are in",
    ):
        assert part in output
    header = read_header(folder / "out" / "strip.h5")
    assert header.complete
    assert header.n_times == 201
    numbers = json.loads((folder / "out" / "strip.json").read_text())
    # Damped to rest: the clamp carries the weight and its moment, the tip hangs by w L^4 / (8 E I).
    assert numbers["joints"]["clamp"]["last force"] == pytest.approx(
        [0, 0, ROOT_WEIGHT], abs=2e-3 * ROOT_WEIGHT
    )
    assert numbers["joints"]["clamp"]["last moment"][1] == pytest.approx(-ROOT_WEIGHT / 2, rel=1e-2)
    stiffness = 2.1e11 * 0.1 * 0.01**3 / 12
    assert numbers["tracked"]["strip.TIP"]["last deflection"][2] == pytest.approx(
        -ROOT_WEIGHT / (8 * stiffness), rel=1e-2
    )
    assert numbers["tracked"]["strip.root"]["last deflection"] == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.mark.slow
def test_a_run_coloured_by_stress_draws_its_contours(case_folder):
    case = case_folder / "strip.toml"
    text = case.read_text().replace("animation = false", 'colour = "von-mises"')
    case.write_text(text.replace("pictures = false\n", "").replace("duration = 0.4", "duration = 0.01"))
    call("run", case, "-o", case_folder / "out")
    assert (case_folder / "out" / "strip-stress.png").is_file()
    assert (case_folder / "out" / "motion.gif").is_file()


def test_stress_that_cannot_be_drawn_is_known_before_the_run(case_folder, monkeypatch):
    """A laminate does not say the stress of its plies; nor is it a matter for the end of a long run."""
    laminate = LaminateSection(1e7 * np.eye(3), np.zeros((3, 3)), 1e2 * np.eye(3), 10.0, 1e-4)
    model = shell_model(read_mesh(case_folder / "strip.inp"), laminate)
    monkeypatch.setattr(Shell, "model", lambda *_: model)
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace("animation = false", 'colour = "von-mises"'))
    output = call("run", case, "-o", case_folder / "out", code=2)
    assert "line 30, output.colour: body 'strip': stress needs a HomogeneousSection" in output
    assert "remove the key" in output
    assert not (case_folder / "out" / "strip.h5").exists()


def test_a_wrong_case_is_an_error_message_and_not_a_traceback(case_folder):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace("thickness", "thicknes"))
    output = call("run", case, "-o", case_folder / "out", code=2)
    assert "error:" in output
    assert "unknown key, did you mean 'thickness'?" in output
    assert "Traceback" not in output
    assert not (case_folder / "out").exists()


def test_debug_shows_the_error_itself(case_folder):
    case = case_folder / "strip.toml"
    case.write_text("title = ")
    result = CliRunner().invoke(app, ["run", str(case), "--debug"])
    assert type(result.exception).__name__ == "CaseError"


def test_node_sets_that_no_mesh_has_are_named_with_their_lines(case_folder):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace('"ROOT"', '"ROT"').replace('"strip.TIP"', '"strip.TOP"'))
    output = call("run", case, "-o", case_folder / "out", code=2)
    assert "has 2 mistakes" in output
    assert (
        "line 14, body[1].interface[1].nodes: there is no node set named 'ROT', did you mean 'ROOT'?"
        in output
    )
    assert (
        "output.track[1]: there is no node set named 'TOP', did you mean 'TIP'?; the mesh has: ROOT, TIP"
        in output
    )


def test_info_of_case_mesh_and_result(finished):
    folder, _ = finished
    assert "shell, basis rubin; interfaces: root" in call("info", folder / "strip.toml")
    mesh = call("info", folder / "strip.inp")
    assert "nodes │ 27 │" in mesh
    assert "node set TIP" in mesh
    result = call("info", folder / "out" / "strip.h5")
    assert "complete" in result
    assert "201, from 0 to 0.4 s" in result


def test_info_of_another_kind_of_file(tmp_path):
    assert "unknown kind of file; give one that ends in .toml" in call("info", tmp_path / "a.txt", code=2)


@pytest.mark.slow
def test_a_run_that_was_cut_off_is_continued_to_the_same_end(finished, tmp_path):
    folder, _ = finished
    case, whole, cut = folder / "strip.toml", folder / "out", tmp_path / "cut"
    solution = read_solution(whole / "strip.h5")
    half = solution.at(slice(100))
    cut.mkdir()
    read = read_case(case)
    units, inputs = {"units": str(read.units)}, read.inputs
    with ResultFile.create(cut / "strip.h5", case=case.read_text(), inputs=inputs, metadata=units) as file:
        file.append(half)
    shutil.copy(whole / "strip-reduced.h5", cut)
    begun_with = (cut / "strip-reduced.h5").stat().st_mtime_ns
    assert "interrupted" in call("info", cut / "strip.h5")
    call("run", case, "-o", cut, "--resume", "--no-errors")
    # Not replaced by one whose columns may have other signs.
    assert (cut / "strip-reduced.h5").stat().st_mtime_ns == begun_with
    continued = read_solution(cut / "strip.h5")
    np.testing.assert_array_equal(continued.times, solution.times)
    ends = [each.bodies["strip"].coordinates[-1] for each in (solution, continued)]
    np.testing.assert_allclose(*ends, atol=1e-3 * np.abs(ends[0]).max())


@pytest.mark.slow
def test_pictures_and_animation_are_drawn(case_folder, monkeypatch):
    monkeypatch.setattr("supple.results.film.N_FRAMES", 4)
    case = case_folder / "strip.toml"
    case.write_text(
        re.sub(r"(pictures|animation|report) = false", r"\1 = true", case.read_text()).replace("0.4", "0.04")
    )
    call("run", case, "-o", case_folder / "out")
    drawn = {path.name for path in (case_folder / "out").iterdir()}
    pictures = {f"strip-{what}.png" for what in ("mesh", "modes", "deformed")}
    assert drawn == pictures | {
        "machine.png",
        "tracked-motion.png",
        "joint-forces.png",
        "motion.gif",
        "strip.h5",
        "strip.json",
        "strip-reduced.h5",
        "report.html",
    }


@pytest.mark.slow
def test_strict_stops_at_a_motion_beyond_the_shell_s_validity(case_folder):
    case = case_folder / "strip.toml"
    case.write_text(case.read_text().replace("2.1e11", "5e8"))
    assert "warning: body 'strip' rotates by" in call("run", case, "-o", case_folder / "out")
    strictly = call("run", case, "-o", case_folder / "out", "--strict", "--force", code=2)
    assert "error: body 'strip' rotates by" in strictly


def test_resuming_a_complete_run_is_refused(finished):
    folder, _ = finished
    output = call("run", folder / "strip.toml", "-o", folder / "out", "--resume", code=2)
    assert "its run is complete" in output


def test_version():
    assert call("--version").strip() == f"supple {__version__}"


def test_info_of_a_case_names_all_that_acts_in_it(pendulum):
    """Elements, sensors, controllers and the spin, besides bodies, joints, loads and springs."""
    more = """control = "law.py:controllers"
[spin]
rate = 2.0
axis = [0.0, 0.0, 1.0]
[[element]]
kind = "angle-stop"
name = "buffer"
first = "ground"
second = "bob.pin"
axis = [0.0, 1.0, 0.0]
lower = -1.0
upper = 1.0
stiffness = 10.0
[[sensor]]
kind = "position"
name = "pin"
at = "bob.pin"
[[sensor]]
kind = "energy"
name = "all"
"""
    (pendulum.parent / "law.py").write_text("")
    first, rest = pendulum.read_text().split("\n\n", 1)
    pendulum.write_text(f"{first}\n{more}\n{rest}")
    shown = call("info", pendulum).replace("│ ", "")
    for words in (
        "element buffer angle-stop: ground - bob.pin",
        "control law.py:controllers",
        "sensor pin position at bob.pin",
        "sensor all energy",
        "spin 2 rad/s about [0.0, 0.0, 1.0]: all bodies",
    ):
        assert words in shown

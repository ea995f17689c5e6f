"""A case in a script: its system and its run are built when they are asked for, its files are read once."""

from __future__ import annotations

import numpy as np
import pytest

from supple.body import body_source
from supple.cases import read_case, run_case
from supple.errors import CaseError
from supple.importers.nastran import deck_file as nastran
from supple.mesh import strip
from supple.quantities import Place
from supple.simulation import simulate
from supple.storage import read_solution

BULK = """\
title = "plate"
gravity = [0, 0, -9.81]

[[body]]
name = "plate"
mesh = "plate.bdf"
nastran = {}
LINEAR
frame = { kind = "mean-axis" }
reduction = { basis = "rubin", modes = 4 }

[[body.interface]]
name = "root"
connection = "rbe2_7"

[[joint]]
kind = "fixed"
first = "ground"
second = "plate.root"

[simulation]
duration = 0.004
output_step = 0.002
step = 0.002

[output]
colour = "von-mises"
"""


def counted(monkeypatch, module, name):
    """The calls of a function from now on."""
    calls, function = [], getattr(module, name)

    def counting(*arguments, **named):
        calls.append(arguments)
        return function(*arguments, **named)

    monkeypatch.setattr(module, name, counting)
    return calls


@pytest.mark.slow
def test_a_script_simulates_a_case(case_folder):
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("duration = 0.4", "duration = 0.01"))
    case = read_case(path)
    assert case.title == "clamped strip"
    solution = simulate(case.system, case.run)
    np.testing.assert_allclose(solution.times, np.arange(6) * 0.002)
    result = run_case(case, case_folder / "out")
    bodies = (solution.bodies["strip"], result.solution.bodies["strip"])
    np.testing.assert_array_equal(*(motion.coordinates for motion in bodies))
    np.testing.assert_array_equal(read_solution(case_folder / "out" / "strip.h5").times, solution.times)
    assert result.numbers["bodies"]["strip"]["coordinates"] == case.system.bodies[0].body.n_coordinates


def test_a_case_is_built_once_and_says_what_it_does(case_folder):
    told: list[str] = []
    case = read_case(case_folder / "strip.toml", lambda step, detail="": told.append(step))
    assert told == []
    assert case.run.duration == 0.4
    assert told == []
    assert case.system is case.system
    assert told[:2] == ["reading meshes", "assembling body 'strip'"]
    assert case.system.bodies[0].body.name == "strip"
    assert len(told) == len(set(told)) == 4
    assert not case.starts


def test_a_reduction_without_a_size_has_a_start(case_folder):
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("modes = 4, derivatives", "accuracy = {}, derivatives"))
    case = read_case(path)
    assert case.starts["strip"].target.relative == 1e-3
    assert case.system.bodies[0].body.n_coordinates == case.flexible["strip"].n


def test_a_place_is_an_interface_or_the_nodes_of_a_set(case_folder):
    case = read_case(case_folder / "strip.toml")
    assert case.place("strip.root") == Place("strip", "root")
    tip = case.place("strip.TIP")
    assert tip.body == "strip"
    np.testing.assert_array_equal(tip.at, case.meshes["strip"].nodes_of("TIP"))


@pytest.mark.slow
@pytest.mark.parametrize("linear", [False, True])
def test_a_nastran_file_is_read_and_assembled_once_a_run(tmp_path, bulk, monkeypatch, linear):
    """Whatever its connections, checks, pictures and animation need of it."""
    mesh = strip(1.0, 0.1, 8, 2)
    rbe2 = bulk.card("RBE2", 7, 900, 123456, *(mesh.nodes_of("root") + 1))
    (tmp_path / "plate.bdf").write_text(bulk.text(mesh, *bulk.shell(0.01), "GRID,900,,0.,0.,0.", rbe2))
    (tmp_path / "plate.toml").write_text(BULK.replace("LINEAR", "linear = true" if linear else ""))
    monkeypatch.setattr("supple.results.film.N_FRAMES", 3)
    reads = counted(monkeypatch, nastran, "read_bulk_data")
    assembled = counted(monkeypatch, body_source, "deck_model")
    run_case(read_case(tmp_path / "plate.toml"), tmp_path / "out")
    assert (len(reads), len(assembled)) == (1, 1)
    assert (tmp_path / "out" / "plate-stress.png").is_file()
    assert (tmp_path / "out" / "motion.gif").is_file()


def test_a_velocity_may_be_that_of_the_centre_of_mass(case_folder):
    """Spinning about its centre, half a metre from the mesh origin."""
    path = case_folder / "strip.toml"
    text = path.read_text().split("[[joint]]")[0] + "[simulation]" + path.read_text().split("[simulation]")[1]
    spinning = "angular_velocity = [0, 0, 4]\n"
    given = text.replace("frame = ", f"{spinning}centre_velocity = [0, 0, 1]\nframe = ")
    path.write_text(given)
    (placed,) = read_case(path).system.bodies
    np.testing.assert_allclose(placed.velocity, [0.0, -2.0, 1.0], atol=1e-9)
    path.write_text(given.replace("centre_velocity", "velocity = [0, 0, 1]\ncentre_velocity"))
    with pytest.raises(
        CaseError, match="centre_velocity: give the velocity of the mesh origin or that of the centre"
    ):
        read_case(path)
    path.write_text(given.replace("centre_velocity", "split = { parts = 2 }\ncentre_velocity"))
    with pytest.raises(CaseError, match="each part of a split body has its own centre"):
        read_case(path)


def test_walls_with_transverse_shear(case_folder):
    path = case_folder / "strip.toml"
    path.write_text(path.read_text().replace("thickness = 0.01,", "thickness = 0.01, shear_factor = 0.8,"))
    (section,) = read_case(path).elements["strip"].sections
    assert (section.property.thickness, section.property.shear_factor) == (0.01, 0.8)

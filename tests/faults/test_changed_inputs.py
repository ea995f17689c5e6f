"""A run is continued only as the run that began: what has changed since is named, and refused."""

from __future__ import annotations

import re
import shutil

import jax.numpy as jnp
import numpy as np
import pytest
from fixtures.bar_case import MOTOR, bar_case
from fixtures.runs_on_disk import RUNS, bits, pendulum

from supple.body import RigidBody
from supple.cases import read_case, run_case
from supple.errors import CaseError, ResultFileError
from supple.importers import files_read_with
from supple.integrate import AdaptiveStep, Run
from supple.machine import GROUND, At, Placed, PrescribedRotation, System
from supple.simulation import simulate
from supple.storage import read_solution
from supple.storage.run_inputs import changes

CASE = bar_case(1.0, 0.05, 0.05, joint=MOTOR)


class StoppedError(Exception):
    pass


def stop(*report):
    if report[-1] > 0.4:
        raise StoppedError


def write_law(path, speed=0.5):
    times = np.linspace(0.0, 1.0, 21)
    np.savetxt(path, np.column_stack([times, speed * times**2]), delimiter=",")


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """The folder of a case, whose run was cut off."""
    folder = tmp_path_factory.mktemp("stopped")
    write_law(folder / "angle.csv")
    (folder / "bar.toml").write_text(CASE)
    with pytest.raises(StoppedError):
        run_case(read_case(folder / "bar.toml"), folder / "out", progress=stop)
    return folder


@pytest.fixture
def cut(stopped, tmp_path):
    """The same folder for each test."""
    return shutil.copytree(stopped, tmp_path, dirs_exist_ok=True)


def resumed(folder, old="", new=""):
    path = folder / "bar.toml"
    path.write_text(path.read_text().replace(old, new) if old else path.read_text())
    return run_case(read_case(path), folder / "out", resume=True).solution


def test_a_file_that_changed_is_named(cut):
    write_law(cut / "angle.csv", speed=0.6)
    with pytest.raises(ResultFileError, match=r"another case \(the file angle\.csv has changed\)"):
        resumed(cut)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass = 1.0", "mass = 2.0", "body 'bar'.rigid.mass was 1.0 and is 2.0"),
        ("duration = 1.0", "duration = 0.5", "simulation.duration was 1.0 and is 0.5"),
        ("step = 0.05\n\n", "step = 0.025\n\n", "simulation.step was 0.05 and is 0.025"),
        ("[0, 0, -9.81]", "[0, 0, 0]", "gravity was"),
    ],
)
def test_a_key_that_changed_is_named_with_both_values(cut, old, new, said):
    with pytest.raises(ResultFileError, match=re.escape(said)):
        resumed(cut, old, new)


@pytest.mark.slow
def test_what_is_only_said_or_drawn_may_change(cut):
    whole = resumed(cut, "[output]", "# a remark\n[output]\ntrack = ['bar.pin']")
    case = read_case(cut / "bar.toml")
    assert bits(whole) == bits(simulate(case.system, case.run))


def test_a_file_keeps_its_units(cut):
    """Its arrays are labelled with them."""
    with pytest.raises(ResultFileError, match=r"its units are not stated, .* are .*m.* now"):
        resumed(cut, "gravity =", 'units = { length = "mm", mass = "t", time = "s" }\ngravity =')


def test_numbers_of_an_earlier_run_do_not_lie_beside_a_new_one(cut):
    path, old = cut / "bar.toml", ("bar.json", "report.html", "sensors.csv", "sensors.h5")
    sensor = '[[sensor]]\nname = "pin"\nkind = "position"\nat = "bar.pin"\n\n[output]'
    path.write_text(path.read_text().replace("[output]", sensor).replace("report = false", "report = true"))
    for name in old:
        (cut / "out" / name).write_text("of an earlier run")
    with pytest.raises(StoppedError):
        run_case(read_case(path), cut / "out", force=True, progress=stop)
    assert not [name for name in old if (cut / "out" / name).exists()]


def test_resume_and_force_exclude_each_other(cut):
    with pytest.raises(CaseError, match="give only one of them"):
        run_case(read_case(cut / "bar.toml"), cut / "out", resume=True, force=True)


def test_included_files_belong_to_a_mesh(tmp_path):
    (tmp_path / "a.inp").write_text("*NODE\n*INCLUDE, INPUT=b.inp\n** *INCLUDE, INPUT=c.inp\n")
    (tmp_path / "b.inp").write_text('*include,input="parts/d.inp"\n')
    (tmp_path / "parts").mkdir()
    for name in ("c.inp", "parts/d.inp", "e.bdf"):
        (tmp_path / name).write_text("")
    (tmp_path / "f.bdf").write_text("BEGIN BULK\nINCLUDE 'e.\nbdf'\nINCLUDE e.bdf\nINCLUDE 'f.bdf'\n")
    found = {path.name for path in files_read_with(tmp_path / "a.inp")}
    assert found == {"a.inp", "b.inp", "d.inp"}
    assert {path.name for path in files_read_with(tmp_path / "f.bdf")} == {"f.bdf", "e.bdf"}


@pytest.mark.parametrize(
    ("files", "first"),
    [
        ({"a.inp": b"*INCLUDE, INPUT=b.inc\n", "b.inc": b"*INCLUDE, INPUT=c.txt\n", "c.txt": b""}, "a.inp"),
        ({"a.inp": "*INCLUDE, INPUT=b\u00fcg.inp\n".encode("latin-1"), "b\u00fcg.inp": b""}, "a.inp"),
        ({"a.inp": "*INCLUDE, INPUT=b.inp\n".encode("utf-16"), "b.inp": b""}, "a.inp"),
        ({"a.bdf": b"BEGIN BULK\nINCLUDE'b.inc'\n", "b.inc": b"include 'c.inc'\n", "c.inc": b""}, "a.bdf"),
        ({"a.dat": b"blade.dat   BldFile - name\n", "blade.dat": b""}, "a.dat"),
        ({"a.sti": b"", "a.dof": b""}, "a.sti"),
        ({"a.py": b"import b, c.d\nfrom e import f\n", "b.py": b"import numpy\n", "e/f.py": b""}, "a.py"),
    ],
)
def test_all_files_that_a_file_is_read_with(tmp_path, files, first):
    """Included by included files, in any encoding, found beside a file, imported by a Python file."""
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    found = {path.relative_to(tmp_path).as_posix() for path in files_read_with(tmp_path / first)}
    assert found == files.keys()


def test_a_file_that_older_results_do_not_list_is_no_change():
    """A deck that includes another file has itself changed."""
    older, now = {"a": "1", "the file a.sti": "2"}, {"a": "1", "the file a.sti": "2", "the file a.dof": "3"}
    assert changes(older, now) == ""
    assert changes(now, older) == "the file a.dof is missing now"
    assert changes(older, now | {"b": "1"}) == "b is new"


SPEED = 2.0


def motor(angle):
    bar = RigidBody("bar", 1.0, (0.5, 0.0, 0.0), np.diag([0.01, 0.1, 0.1]), {"pin": (0.0, 0.0, 0.0)})
    turn = PrescribedRotation(
        name="motor", first=GROUND, second=At("bar", "pin"), axis=(0.0, 1.0, 0.0), angle=angle
    )
    return System((Placed(bar),), (turn,))


def turning(speed):
    return lambda time: jnp.asarray(speed) * time**2


def with_global(time):
    return SPEED * time**2


@pytest.mark.slow
def test_a_script_that_changed_is_refused_by_what_changed(tmp_path, monkeypatch):
    run, path = Run(duration=0.2, output_step=0.05), tmp_path / "run.h5"
    simulate(motor(turning(2.0)), run, file=path)
    simulate(motor(turning(2.0)), run, file=path)  # another function of the same text and numbers
    with pytest.raises(ResultFileError, match=r"joint 'motor' has changed"):
        simulate(motor(turning(3.0)), run, file=path)
    with pytest.raises(ResultFileError, match=r"the run was 0\.2 from .* and is 0\.2"):
        simulate(motor(turning(2.0)), Run(0.2, 0.05, step=AdaptiveStep(1e-3, 0.05, 1e-6)), file=path)
    simulate(motor(with_global), run, file=path, overwrite=True)
    monkeypatch.setattr(f"{__name__}.SPEED", 3.0)
    with pytest.raises(ResultFileError, match=r"joint 'motor' has changed"):
        simulate(motor(with_global), run, file=path)


@pytest.mark.slow
def test_a_heavier_body_is_another_run(tmp_path):
    simulate(pendulum(), RUNS["fixed"], file=tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="body 'bar' has changed"):
        simulate(pendulum(mass=2.0), RUNS["fixed"], file=tmp_path / "run.h5")
    assert read_solution(tmp_path / "run.h5").times[-1] == 1.0

"""Whatever a file holds, or a path is, a command answers with a message of its own."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import supple as sp
from supple.cli.main import app
from supple.errors import CaseError, ImportFormatError
from supple.importers import read_polar
from supple.importers.turbine.windio import read_windio_blade
from supple.simulation import store_body
from supple.storage import file_name
from supple.terminal import FAULT, MISTAKE

CASE = """\
title = '''{title}'''
[[body]]
name = '''{name}'''
rigid = {{ mass = 1.0, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }}
interface = [{{ name = "a", position = [0, 0, 0] }}]
[[joint]]
kind = "ball"
first = "ground"
second = '''{name}.a'''
[simulation]
duration = 0.02
output_step = 0.01
step = 0.01
[output]
track = ['''{name}.a''']
animation = false
"""


def run(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["[/bold] [red", "a/../b", "x$y^{ $", "\\", "%2F", "Łódź °"])
def test_names_with_markup_and_slashes(name, tmp_path):
    """Printed as they are, drawn as they are, and all files within the folder."""
    path = tmp_path / "case.toml"
    path.write_text(CASE.format(title=f"title {name}", name=name.replace(".", "")), encoding="utf-8")
    ended = run("run", path, "-o", tmp_path / "out")
    assert ended.exit_code == 0, ended.output
    assert f"title {name}" in ended.output
    assert {each.name for each in tmp_path.iterdir()} == {"case.toml", "out"}
    assert name.replace(".", "") in run("info", path).output.replace("\n", "")


@pytest.mark.parametrize("name", ["../out", "a/b", "..", "", "x" * 300, "nul\0", "a:b"])
def test_files_of_bodies_lie_in_their_folder(name, tmp_path, reduced_beam):
    body = replace(reduced_beam, name=name.replace("\0", ""))
    written = store_body(body, tmp_path / "run")
    assert written.parent == tmp_path / "run"
    assert sp.read_reduced_body(written).name == body.name


def test_names_of_files_stay_apart():
    names = ["a/b", "a%2Fb", "a\\b", "a b", ".", "..", "%2E", "", "%", "x" * 300, "x" * 299, "\udcff", "é"]
    made = [file_name(name) for name in names]
    assert len(set(made)) == len(names)
    assert all("/" not in each and len(os.fsencode(each)) <= 150 for each in made)
    assert file_name("blade 1") == "blade 1"


@pytest.fixture(scope="module")
def reduced_beam():
    model = sp.solid_model(
        sp.block(1.0, 0.1, 0.1, 2, 1, 1, sp.CellType.TETRA4), sp.Isotropic(2e11, 0.3, 7800.0)
    )
    body = sp.flexible_body("beam", model, [sp.RigidInterface("root", "root")])
    return sp.reduce(
        body, sp.MeanAxisFrame(), sp.CraigBampton(n_modes=1), derivatives=sp.NoDerivatives(), loads=sp.NoLoads
    )


LONG = "a" * 300


@pytest.mark.parametrize("suffix", [".toml", ".inp", ".msh", ".bdf", ".h5"])
@pytest.mark.parametrize("name", [LONG, "absent", "\udcff\udcfe", "folder/no", "[red]"])
def test_paths_that_are_no_files(name, suffix, tmp_path):
    ended = run("info", tmp_path / f"{name}{suffix}")
    assert ended.exit_code == MISTAKE, ended.output
    assert "Traceback" not in ended.output
    assert "error:" in ended.output


def test_a_file_that_may_not_be_read(tmp_path, monkeypatch):
    path = tmp_path / "m.inp"
    path.write_text("*NODE\n")

    def refuse(_):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("pathlib.Path.read_bytes", refuse)
    with pytest.raises(ImportFormatError, match=r"m\.inp: cannot be read \(Permission denied\)"):
        sp.read_abaqus(path)


@pytest.mark.parametrize("below", ["", "/deeper"])
def test_a_file_has_the_name_of_the_folder(below, tmp_path):
    path, taken = tmp_path / "case.toml", tmp_path / "taken"
    path.write_text(CASE.format(title="t", name="b"))
    taken.write_text("")
    ended = run("run", path, "-o", f"{taken}{below}")
    assert ended.exit_code == MISTAKE
    assert "a file" in ended.output
    assert "required folder" in ended.output
    ended = run("run", path, "-o", tmp_path / LONG)
    assert ended.exit_code == MISTAKE
    assert "choose a shorter one" in ended.output


def test_a_fault_of_our_own_says_so(tmp_path, monkeypatch):
    def broken(*_):
        raise KeyError("[bold]lost[/bold]")

    monkeypatch.setattr("supple.cli.info.print_rows", broken)
    path = tmp_path / "case.toml"
    path.write_text(CASE.format(title="t", name="b"))
    ended = run("info", path)
    assert ended.exit_code == FAULT
    assert "KeyError: '[bold]lost[/bold]'" in ended.output
    assert "--debug" in ended.output
    assert isinstance(run("info", path, "--debug").exception, KeyError)


DEEP = 10_000


@pytest.mark.parametrize(
    "text",
    [
        f"a = {'[' * DEEP}{']' * DEEP}",
        f"a = {'{a=' * DEEP}1{'}' * DEEP}",
        pytest.param(f"{'a.' * DEEP}a = 1", marks=pytest.mark.slow),
        f"[{'a.' * DEEP}a]",
    ],
)
def test_a_case_that_nests_deep(text, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises(CaseError, match="nest more than 20 deep"):
        sp.read_case(path)


def test_a_blade_that_nests_deep(tmp_path):
    path = tmp_path / "blade.yaml"
    path.write_text("[" * DEEP)
    with pytest.raises(ImportFormatError, match="nest too deep"):
        read_windio_blade(path)


def test_a_number_of_thousands_of_digits(tmp_path):
    assert sys.get_int_max_str_digits() < 5000
    path = tmp_path / "case.toml"
    path.write_text(f"a = {'1' * 5000}")
    with pytest.raises(CaseError, match="not valid TOML"):
        sp.read_case(path)


def test_words_of_yaml_1_1_are_no_numbers(tmp_path):
    """1_000, 1:30 and 010 are 1000, 90 and 8 to YAML 1.1."""
    blade = (Path(__file__).parents[1] / "importers/turbine/windio_blade/version_1.yaml").read_text()
    assert "\n" in blade
    path = tmp_path / "blade.yaml"
    path.write_text(blade)
    chord = read_windio_blade(path).chord
    assert np.isfinite(chord).all()
    start = blade.index("values: [", blade.index("chord:")) + len("values: [")
    for word in ("1_000", "1:30", "١"):
        end = blade.index(",", start)
        path.write_text(f"{blade[:start]}{word}{blade[end:]}", encoding="utf-8")
        with pytest.raises(ImportFormatError, match=r"chord\.values holds entries that are not numbers"):
            read_windio_blade(path)


def test_quotes_that_do_not_close(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text('alpha_deg,cl,cd\n-180,0,0\n"180,0,0\n')
    with pytest.raises(ImportFormatError, match=r"t\.csv, line 3: not a row of a CSV table"):
        read_polar(path, name="t")


def test_hundreds_of_mistakes_are_told_at_once(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('title = "t"\nbody = []\n' + 500 * "[[load]]\n")
    began = time.process_time()
    with pytest.raises(CaseError, match=r"case\.toml has 502 mistakes"):
        sp.read_case(path)
    assert time.process_time() - began < 10.0

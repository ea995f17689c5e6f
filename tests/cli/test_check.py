"""`supple check`: a table of findings and an exit code that scripts can trust; imported bodies in cases."""

from __future__ import annotations

import re

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from supple.cases import read_case
from supple.cli.main import app
from supple.errors import CaseError, ModelError
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.mesh import strip

MESH = strip(1.0, 0.1, 8, 2)
STEEL = Isotropic(2.1e11, 0.3, 7850.0)


def call(*arguments, code=0):
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == code, result.output
    return re.sub(r"\s+", " ", re.sub("[│┃]", " ", result.output))


@pytest.fixture
def folder(tmp_path, bulk):
    """The strip of the other tests as bulk data, its root tied by an RBE2, and as HDF5 matrices."""
    root = MESH.nodes_of("root") + 1
    rbe2 = bulk.card("RBE2", 7, 900, 123456, *root)
    (tmp_path / "strip.bdf").write_text(bulk.text(MESH, *bulk.shell(0.01), "GRID,900,,0.,0.,0.", rbe2))
    write_matrices(tmp_path / "strip.h5", shell_model(MESH, HomogeneousSection(STEEL, 0.01)))
    (tmp_path / "strip.toml").write_text(CASE)
    return tmp_path


def write_matrices(path, model, ground=0.0):
    ids = np.arange(1, model.mesh.n_nodes + 1)
    with h5py.File(path, "w") as file:
        file["nodes"] = model.mesh.nodes
        file["freedoms"] = np.column_stack([np.repeat(ids, 6), np.tile(np.arange(1, 7), len(ids))])
        file["node_sets/root"] = model.mesh.nodes_of("root") + 1
        for name, matrix in (("stiffness", model.stiffness.copy()), ("mass", model.mass)):
            if name == "stiffness":
                matrix[0, 0] += ground
            for part in ("data", "indices", "indptr"):
                file[f"{name}/{part}"] = getattr(matrix, part)


CASE = """\
title = "clamped strip"

[[body]]
name = "strip"
mesh = "strip.bdf"
nastran = {}
frame = { kind = "mean-axis" }
reduction = { basis = "rubin", modes = 4 }

[[body.interface]]
name = "root"
connection = "rbe2_7"

[[body]]
name = "copy"
mesh = "strip.h5"
matrices = { stiffness = "strip.h5", mass = "strip.h5" }
frame = { kind = "mean-axis" }
reduction = { basis = "rubin", modes = 4 }

[[body.interface]]
name = "root"
nodes = "root"
position = [0, 0, 0]

[[joint]]
kind = "fixed"
first = "ground"
second = "strip.root"

[[joint]]
kind = "fixed"
first = "ground"
second = "copy.root"

[simulation]
duration = 0.004
output_step = 0.002
step = 0.002

[output]
pictures = false
animation = false
report = false
"""


def test_a_good_model_prints_its_table(folder):
    output = call("check", folder / "strip.bdf")
    assert re.search(r"OK\s+mass and centre\s+7\.85 at \(0\.5, 0, 0\)", output)
    assert "6, as for a free body" in output
    assert "lowest free frequencies" in output
    assert "problem" not in output
    assert "lowest free frequencies" not in call("check", folder / "strip.bdf", "--modes", "0")


@pytest.mark.slow
def test_all_bodies_of_a_case_and_matrices_on_their_own(folder):
    output = call("check", folder / "strip.toml")
    assert "Check of body 'strip'" in output
    assert "Check of body 'copy'" in output
    assert "free of supports" in call("check", folder / "strip.h5")


def test_a_refused_model_is_an_exit_code(folder):
    write_matrices(folder / "strip.h5", shell_model(MESH, HomogeneousSection(STEEL, 0.01)), ground=1e9)
    output = call("check", folder / "strip.h5", code=2)
    assert re.search(r"problem\s+free of supports\s+in translation along x,", output)
    assert "-> leave supports and springs to ground out" in output
    assert "strip.h5: refused; see the lines marked 'problem'" in output


def test_a_mesh_without_materials_is_no_whole_model(folder):
    (folder / "strip.msh").touch()
    output = call("check", folder / "strip.msh", code=2)
    assert "strip.msh: not a complete model: check reads .toml, .inp, .bdf" in output
    assert "write a case: supple new" in output


def test_a_mesh_of_elements_without_sections_is_no_whole_model(tmp_path):
    mesh = tmp_path / "plate.inp"
    mesh.write_text("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT, TYPE=S3, ELSET=A\n1,1,2,3\n")
    said = call("check", mesh, code=2)
    assert "a mesh without sections is not a complete model" in said
    assert "supple new" in said
    mesh.write_text(mesh.read_text() + "*SHELL SECTION, ELSET=A, MATERIAL=STEAL\n0.01\n")
    assert "of material 'STEAL', which is not defined, are missing" in call("check", mesh, code=2)


def test_bodies_without_elements_are_named(pendulum):
    assert "not checked, because they have no elements or matrices here: 'bob'" in call("check", pendulum)


def test_info_of_bulk_data_shows_what_it_holds(folder):
    output = call("info", folder / "strip.bdf")
    assert re.search(r"node set rbe2_7\s+3 nodes", output)
    assert re.search(r"mass\s+7\.85", output)


def test_both_bodies_of_the_case_are_the_same(folder):
    case = read_case(folder / "strip.toml")
    assert list(case.meshes) == ["strip"]
    strip_body, copy = case.flexible.values()
    assert abs(strip_body.stiffness - copy.stiffness).max() <= 1e-14 * abs(copy.stiffness).max()
    np.testing.assert_array_equal(strip_body.interface("root").position, copy.interface("root").position)
    assert copy.model is None


def test_a_refused_body_is_not_run(folder):
    write_matrices(folder / "strip.h5", shell_model(MESH, HomogeneousSection(STEEL, 0.01)), ground=1e9)
    case = read_case(folder / "strip.toml")
    with pytest.raises(ModelError, match=r"(?s)body 'copy' cannot be used.*free of supports.*leave supports"):
        assert case.flexible


@pytest.mark.slow
def test_an_rbe2_that_is_no_interface_ties_its_nodes_all_the_same(folder):
    """It stiffens the body as in Nastran, whatever the interface there."""
    table = 'connection = "rbe2_7"'
    for given in ('nodes = "rbe2_7"', 'nodes = "rbe2_7"\nkind = "averaging"'):
        (folder / "strip.toml").write_text(CASE.replace(table, given))
        body = read_case(folder / "strip.toml").flexible["strip"]
        tied = body.model.attached.rigid[0].nodes
        moved = (body.expansion @ np.random.default_rng(1).normal(size=body.n)).reshape(-1, 6)[tied]
        np.testing.assert_allclose(moved[:, 3:], moved[:1, 3:].repeat(len(tied), axis=0), atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('mesh = "strip.bdf"', 'mesh = "strip.h5"', "'strip.h5' is not a readable mesh; give a file .bdf or"),
        ('mesh = "strip.h5"\n', "", "a matrices body needs a mesh"),
        ('stiffness = "strip.h5"', 'stiffness = "absent.h5"', "there is no file .*absent.h5"),
        (
            'connection = "rbe2_7"',
            'connection = "rbe2_7"\nnodes = "root"',
            "this one has nodes and connection",
        ),
        (
            'connection = "rbe2_7"',
            'connection = "rbe2_7"\nkind = "rigid"',
            "the mesh file defines the kind of a connection; remove",
        ),
        (
            "nastran = {}",
            "shell = {thickness = 1.0, youngs_modulus = 1.0, poissons_ratio = 0.0, density = 1.0}",
            "only nastran and abaqus and matrices bodies have connections; give nodes",
        ),
        (
            'basis = "rubin", modes = 4 }\n\n[[body.interface]]\nname = "root"\nnodes',
            'basis = "rubin", modes = 4, derivatives = {kind = "picked", number = 1} }\n\n'
            '[[body.interface]]\nname = "root"\nnodes',
            "a linear body has no modal derivatives",
        ),
    ],
)
def test_case_files_that_break_the_rules(folder, old, new, message):
    assert old in CASE
    (folder / "strip.toml").write_text(CASE.replace(old, new, 1))
    with pytest.raises(CaseError, match=message):
        read_case(folder / "strip.toml")


def test_a_load_at_a_node_set_of_matrices_is_refused(folder):
    load = '\n[[load]]\nkind = "force"\nat = "copy.tip"\nvector = [0, 0, 1]\n'
    (folder / "strip.toml").write_text(CASE + load)
    with pytest.raises(CaseError, match="there is no interface of 'copy' named 'tip'"):
        read_case(folder / "strip.toml")


@pytest.mark.slow
def test_the_case_runs(folder):
    output = call("run", folder / "strip.toml", "-o", folder / "out")
    assert "checked body 'copy': free, no mechanism, symmetric, mass 7.85" in output
    assert "Results are in" in output

"""Split bodies in case files: the same machine, its parts where the body was."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.abaqus_text import abaqus_text

from supple.body import LinearRayleighDamping, RayleighDamping
from supple.cases import read_case, run_case, static_case
from supple.cases.static_case import spin_of
from supple.errors import CaseError, ModelError, SuppleWarning
from supple.importers import read_mesh
from supple.machine import At
from supple.mesh import CellType, block, strip

SPLIT = "frame = { kind = "


def rewritten(folder, *changes):
    path = folder / "strip.toml"
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


@pytest.mark.slow
def test_a_split_strip_bends_as_the_whole_one(case_folder, tmp_path):
    """Slow bending under its weight, small enough that one frame is right as well."""
    short = ("duration = 0.4", "duration = 0.1"), ("-9.81", "-2.0")
    whole = run_case(read_case(rewritten(case_folder, *short)), tmp_path / "whole")
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT))
    heard = []
    split = run_case(read_case(path, notify=lambda step, *_: heard.append(step)), tmp_path / "split")
    assert [placed.body.name for placed in split.system.bodies] == ["strip-1", "strip-2"]
    assert [joint.name for joint in split.system.joints] == ["clamp", "strip cut-1"]
    assert list(split.tracked) == ["strip-2.TIP", "strip-1.root"]
    tip, expected = (
        run.tracked[name].position for run, name in ((split, "strip-2.TIP"), (whole, "strip.TIP"))
    )
    sag = np.ptp(expected[:, 2])
    assert sag > 1e-3
    assert abs(tip - expected).max() < 5e-3 * sag
    seen, expected = (run.tracked[name] for run, name in ((split, "strip-2.TIP"), (whole, "strip.TIP")))
    assert (seen.seen_from, expected.seen_from) == ("strip-1.root", "root")
    assert abs(seen.deflection - expected.deflection).max() < 5e-3 * sag
    assert any("into 2; the ties change its lowest free frequencies by" in line for line in heard)


@pytest.mark.slow
def test_a_split_strip_at_rest_is_seen_from_where_its_run_sees_it(case_folder, tmp_path):
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT), ("-9.81", "-2.0"))
    found = static_case(read_case(path), tmp_path / "split")
    tip = found.tracked["strip-2.TIP"]
    assert tip.seen_from == "strip-1.root"
    numbers = found.numbers["tracked"]["strip-2.TIP"]
    # Clamped at the root, what is deflected is what has moved.
    assert numbers["error of deflection"] == pytest.approx(numbers["error of position"], abs=1e-12)
    assert abs(numbers["error of position"]).max() < 0.01 * abs(tip.deflection).max()


def test_loads_on_nodes_are_shared_out_and_frames_follow_the_cuts(case_folder):
    load = '[[load]]\nkind = "force"\nat = "strip.ALL"\nvector = [0, 0, 17.0]\n\n[simulation]'
    mesh = case_folder / "strip.inp"
    mesh.write_text(mesh.read_text() + "*NSET, NSET=ALL, GENERATE\n1, 27, 1\n")
    path = rewritten(
        case_folder,
        (
            SPLIT + '"mean-axis" }',
            'split = { parts = 3 }\nframe = { kind = "nodal-fixed", interface = "root" }',
        ),
        ('basis = "rubin", modes = 4', 'basis = "craig-bampton", modes = 2'),
        ("[simulation]", load),
    )
    system = read_case(path).system
    tables = read_case(path).parts
    assert [body.frame.interface for body in tables.body] == ["root", "cut-1", "cut-2"]
    assert sum(np.sum(each.vector) for each in tables.load) == pytest.approx(17.0)
    nodes = [each.nodes for each in system.loads]
    assert sum(len(each) for each in nodes) == 27


PRESSED = """
title = "pressed on all sides"
[[body]]
name = "bar"
mesh = "bar.inp"
MATERIAL
frame = { kind = "mean-axis" }
reduction = { basis = "none" }
split = { parts = 3 }

[[load]]
kind = "pressure"
at = "bar.ALL"
pressure = 2.0

[simulation]
duration = 1.0
output_step = 0.1
step = 0.1
"""


@pytest.mark.filterwarnings("ignore:body 'bar'. the ties of its 3 parts:supple.errors.SuppleWarning")
@pytest.mark.parametrize(
    ("mesh", "material", "area"),
    [
        (strip(1.0, 0.1, 6, 2), "shell = { thickness = 0.01, ", 0.1),
        (block(1.0, 0.2, 0.1, 6, 1, 1, CellType.HEXA8), "solid = { ", 0.64),
    ],
)
def test_a_pressure_acts_on_the_faces_beside_a_cut_and_not_in_it(tmp_path, mesh, material, area):
    every = ",\n".join(map(str, mesh.node_ids + 1))
    (tmp_path / "bar.inp").write_text(abaqus_text(mesh) + f"*NSET, NSET=ALL\n{every}\n")
    material += "youngs_modulus = 1e9, poissons_ratio = 0.3, density = 1000.0 }"
    (tmp_path / "bar.toml").write_text(PRESSED.replace("MATERIAL", material))
    case = read_case(tmp_path / "bar.toml")
    pressed = 0.0
    for load in case.system.loads:
        corners = case.meshes[load.body].nodes[np.asarray(load.faces)]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        pressed += np.linalg.norm(across, axis=1).sum() / 2
    assert [load.body for load in case.system.loads] == ["bar-1", "bar-2", "bar-3"]
    assert pressed == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "made"), [("rayleigh-ratio", RayleighDamping), ("linear-rayleigh-ratio", LinearRayleighDamping)]
)
def test_a_ratio_on_modes_is_one_on_those_of_the_whole(case_folder, kind, made):
    ratio = f'{{ kind = "{kind}", ratio = 0.02, modes = [1, 2], held = "root" }}'
    path = rewritten(case_folder, ('{ kind = "rayleigh", alpha = 0.0, beta = 0.02 }', ratio))
    case = read_case(path)
    body = case.tables.body[0]
    expected = body.damping.build(case.flexible["strip"], body.frame.build())
    rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT))
    with pytest.warns(SuppleWarning, match="is split: its mass damping, alpha"):
        damped = [part.damping.build() for part in read_case(path).parts.body]
    assert damped == [made(expected.alpha, expected.beta)] * 2


@pytest.mark.parametrize(
    ("split", "message"),
    [
        ("{}", r"a split needs parts = 2, or cell_sets = \[\.\.\.\]; this one has neither"),
        ('{ parts = 2, cell_sets = ["A", "B"] }', r"this one has parts and cell_sets"),
        ('{ cell_sets = ["A", "B"], body_axis = [1, 0, 0] }', r"parts from cell sets have no body_axis"),
        (
            "{ parts = 2, axis = [1, 0, 0] }",
            r"body\[1\]\.split\.axis: axis is now body_axis: .* axes of the body",
        ),
        ('{ cell_sets = ["A"] }', r"at least two cell sets"),
        ("{ parts = 1 }", r"greater than or equal to 2|at least 2"),
    ],
)
def test_impossible_splits_are_refused(case_folder, split, message):
    path = rewritten(case_folder, (SPLIT, f"split = {split}\n" + SPLIT))
    with pytest.raises(CaseError, match=message):
        read_case(path)


def test_an_interface_across_a_cut_is_refused(case_folder):
    mesh = case_folder / "strip.inp"
    mesh.write_text(mesh.read_text() + "*NSET, NSET=EDGE, GENERATE\n4, 25, 3\n")
    edge = '[[body.interface]]\nname = "edge"\nnodes = "EDGE"\n\n[[joint]]'
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT), ("[[joint]]", edge))
    with pytest.raises(ModelError, match=r"interface 'edge': its nodes lie in several of the 2 parts"):
        read_case(path).system  # noqa: B018


def test_ids_of_nodes_are_those_of_the_file_in_every_part(case_folder):
    mesh = read_mesh(case_folder / "strip.inp")
    tip = mesh.nodes_of("TIP")
    far = (
        '[[body.interface]]\nname = "far"\nkind = "averaging"\n'
        f"node_indices = {mesh.node_ids[tip].tolist()}\n\n[[joint]]"
    )
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT), ("[[joint]]", far))
    part = read_case(path).flexible["strip-2"]
    np.testing.assert_array_equal(part.nodes[part.interface("far").node_ids], mesh.nodes[tip])


@pytest.mark.slow
def test_the_parts_of_a_split_body_rotate(case_folder):
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT))
    path.write_text(path.read_text() + "\n[spin]\nrate = 2.0\naxis = [0, 0, 1]\nbodies = ['strip']\n")
    assert list(spin_of(read_case(path)).bodies) == ["strip-1", "strip-2"]


def test_what_is_read_at_a_split_body_is_read_at_its_part(case_folder):
    """Sensors and quantities of the error; a joint without a name is called by the ends that it was given."""
    read = (
        '[[sensor]]\nname = "pull"\nkind = "joint-force"\njoint = "fixed ground - strip.root"\n'
        '[[sensor]]\nname = "tip"\nkind = "position"\nat = "strip.TIP"\n'
        '[[sensor]]\nname = "turn"\nkind = "angular-velocity"\nat = "strip.root"\n'
        '[error]\nof = [{ kind = "deflection", at = "strip.TIP" }, '
        '{ kind = "joint-force", joint = "fixed ground - strip.root" }]\n'
    )
    for split in ("", "split = { parts = 2 }\n"):
        path = rewritten(case_folder, (SPLIT, split + SPLIT), ("[simulation]", read + "[simulation]"))
        path.write_text(path.read_text().replace('name = "clamp"\n', ""))
        case = read_case(path)
        body = "strip-2" if split else "strip"
        assert case.system.joints[0].name == "fixed ground - strip.root"
        force, tip, turn = case.sensors
        assert turn.at == At("strip-1" if split else "strip", "root")
        assert (force.joint, tip.place.body) == ("fixed ground - strip.root", body)
        deflection, pull = case.study.quantities
        assert (deflection.body, pull.joint) == (body, "fixed ground - strip.root")
        path.write_text(path.read_text().replace(read, ""))


def test_a_set_that_lies_in_several_parts_is_none_to_read_at(case_folder):
    mesh = case_folder / "strip.inp"
    mesh.write_text(mesh.read_text() + "*NSET, NSET=ALL, GENERATE\n1, 27, 1\n")
    sensor = '[[sensor]]\nname = "mean"\nkind = "position"\nat = "strip.ALL"\n[simulation]'
    path = rewritten(case_folder, (SPLIT, "split = { parts = 2 }\n" + SPLIT), ("[simulation]", sensor))
    with pytest.raises(
        ModelError, match=r"sensor 'mean': the nodes of 'strip.ALL' lie in 2 of the parts; name an"
    ):
        _ = read_case(path).system

"""Every mistake that a case file can hold is reported with its line and its remedy, all in one error."""

from __future__ import annotations

import pytest

from supple.cases import read_case
from supple.cases.reductions import NoDerivatives, Picked, Rubin, derivative_choice
from supple.errors import CaseError

GOOD = """\
title = "one blade"
gravity = [0.0, 0.0, -9.81]

[[body]]
name = "blade"
mesh = "blade.inp"
shell = { thickness = 0.02, youngs_modulus = 61.13e9, poissons_ratio = 0.3, density = 1474.9 }
frame = { kind = "mean-axis" }
reduction = { basis = "rubin", modes = 10, derivatives = { kind = "picked", number = 5 } }
damping = { kind = "rayleigh-ratio", ratio = 0.02, modes = [1, 2] }

[[body.interface]]
name = "root"
nodes = "ROOT"

[[body.interface]]
name = "tip"
nodes = "TIP"
kind = "averaging"

[[body]]
name = "hub"
rigid = { mass = 10, inertia = [[1, 0, 0], [0, 1, 0], [0, 0, 1]] }

[[body.interface]]
name = "flange"
position = [0, 0, -1.5]

[[joint]]
kind = "prescribed-rotation"
first = "ground"
second = "hub.flange"
axis = [1, 0, 0]
law = { kind = "spin-up", speed = 1.267, duration = 10.0 }

[[joint]]
kind = "fixed"
first = "hub.flange"
second = "blade.root"

[[load]]
kind = "force"
at = "blade.LE"
vector = [1000.0, 0, 0]
law = { kind = "ramp", value = 1, duration = 2.0 }

[[spring]]
kind = "straight"
first = "hub.flange"
second = "blade.tip"
stiffness = 10.0

[simulation]
duration = 20
output_step = 0.02
step = 0.02

[output]
track = ["blade.tip", "blade.TE"]
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with the files that GOOD names; their content matters only when the case is built."""
    for name in ("blade.inp", "k.mtx", "m.mtx", "nodes.csv", "blade.txt"):
        (tmp_path / name).touch()
    return tmp_path


def read(folder, text):
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return read_case(path)


def mistakes(folder, text):
    with pytest.raises(CaseError) as caught:
        read(folder, text)
    return str(caught.value)


def line_of(text, part):
    """Line (from 1) of the only place where `part` stands."""
    assert text.count(part) == 1
    return text[: text.index(part)].count("\n") + 1


def test_a_good_case_is_read_into_typed_tables(folder):
    case = read(folder, GOOD).tables
    assert [body.name for body in case.body] == ["blade", "hub"]
    assert isinstance(case.body[0].reduction, Rubin)
    assert case.body[0].reduction.derivatives == Picked(kind="picked", number=5)
    assert case.body[0].shell is not None
    assert case.body[0].shell.kinematics == "green-lagrange"
    assert case.joint[0].axis == (1.0, 0.0, 0.0)
    assert case.simulation.rho_inf == 0.8
    assert case.output.pictures


def test_derivatives_are_off_unless_asked_for(folder):
    body = read(folder, GOOD.replace(', derivatives = { kind = "picked", number = 5 }', "")).tables.body[0]
    assert isinstance(body.reduction, Rubin)
    assert body.reduction.derivatives is None
    assert derivative_choice(None) == derivative_choice(NoDerivatives(kind="none"))


SIZES = 'reduction = { basis = "rubin", modes = 10, derivatives = { kind = "picked", number = 5 } }'
DAMPING = 'damping = { kind = "rayleigh-ratio", ratio = 0.02, modes = [1, 2] }'


@pytest.mark.parametrize(
    ("reduction", "corrects"),
    [
        (SIZES, False),
        ('reduction = { basis = "rubin", modes = 10 }', False),
        ('reduction = { basis = "guyan" }', False),
        ('reduction = { basis = "none" }', False),
        ("", True),
        ('reduction = { basis = "craig-bampton" }', True),
        ('reduction = { basis = "guyan", accuracy = { absolute = 1e-4 } }', True),
        (SIZES.replace(" } }", " }, accuracy = { relative = 1e-2 } }"), True),
        (SIZES.replace("rubin", "herting"), False),
        ('reduction = { basis = "craig-bampton-residual" }', True),
        ('reduction = { basis = "error-controlled", tolerance = 1e-3, modes = 10 }', False),
    ],
)
def test_a_reduction_corrects_itself_unless_its_size_is_fixed(folder, reduction, corrects):
    body = read(folder, GOOD.replace(SIZES, reduction)).tables.body[0]
    assert body.corrects_itself is corrects


@pytest.mark.parametrize("reduction", ['reduction = { basis = "none" }', ""])
def test_modal_damping_of_so_many_modes_needs_no_fixed_size(folder, reduction):
    modal = 'damping = { kind = "modal", ratio = 0.02, modes = 12 }'
    body = read(folder, GOOD.replace(SIZES, reduction).replace(DAMPING, modal)).tables.body[0]
    assert body.damping.build().n_modes == 12


def test_a_rigid_body_has_nothing_to_correct(folder):
    assert not read(folder, GOOD).tables.body[1].corrects_itself


# (what stands in GOOD, what is written instead, what the message says at the line of the new text)
ONE_MISTAKE = {
    "unknown key": (
        "thickness = 0.02",
        "thicknes = 0.02",
        "shell.thicknes: unknown key, did you mean 'thickness'?",
    ),
    "unknown key, nothing near": (
        "duration = 20",
        "duration = 20\nzzz = 1",
        "simulation.zzz: unknown key; known keys",
    ),
    "unknown key in a chosen table": (
        "modes = 10",
        "modes = 10, mods = 2",
        "reduction.mods: unknown key, did you mean",
    ),
    "missing key": (
        ", density = 1474.9",
        "",
        "shell.density: this key is missing; add it (mass density, mass per volume)",
    ),
    "missing number": (
        ", number = 5",
        "",
        "reduction.derivatives.number: this key is missing; add it (derivatives",
    ),
    "a string for a number": (
        "= 0.02, y",
        '= "0.02", y',
        "should be a valid number, got '0.02' (wall thickness, a length)",
    ),
    "a fraction for a count": (
        "modes = 10",
        "modes = 2.5",
        "should be a valid integer, got 2.5 (vibration modes",
    ),
    "out of range": ("poissons_ratio = 0.3", "poissons_ratio = 0.5", "should be less than 0.5, got 0.5"),
    "negative": (
        "duration = 10.0",
        "duration = -10.0",
        "law.duration: should be greater than 0, got -10.0 (duration of the spin-up, a time)",
    ),
    "not finite": (
        "stiffness = 10.0",
        "stiffness = inf",
        "should be a finite number, got inf (k, force per length)",
    ),
    "number instead of a row": (
        "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        "[0.5, [0, 1, 0], [0, 0, 1]]",
        "body[2].rigid.inertia[1]: 3 items in brackets, [.., ..], are needed, got 0.5",
    ),
    "text instead of a table": (
        '{ kind = "mean-axis" }',
        '"mean-axis"',
        "body[1].frame: a table, { key = value, .. }, is needed, got 'mean-axis'",
    ),
    "short vector": ("[0.0, 0.0, -9.81]", "[0.0, 0.0]", "gravity: 3 items are needed, got [0.0, 0.0]"),
    "long vector": (
        "[0.0, 0.0, -9.81]",
        "[0.0, 0.0, 1.0, 2.0]",
        "gravity: at most 3 items are allowed, got [0.0",
    ),
    "unknown kind": (
        '"mean-axis"',
        '"mean-axs"',
        "frame.kind: 'mean-axs' is not known, did you mean 'mean-axis'?",
    ),
    "missing kind": (
        'basis = "rubin", ',
        "",
        "reduction.basis: this key is missing; add basis = one of complete, craig-bampton",
    ),
    "unknown joint": (
        '"fixed"',
        '"fixd"',
        "joint[2].kind: 'fixd' is not known, did you mean 'fixed'?; choose one of",
    ),
    "unknown interface kind": (
        '"averaging"',
        '"RBE3"',
        "interface[2].kind: 'RBE3' is not known; choose one of rigid",
    ),
    "two kinds of body": (
        'name = "hub"',
        'name = "hub"\nshell = {thickness = 1, youngs_modulus = 1, poissons_ratio = 0, density = 1}',
        "a body needs exactly one of shell, solid, nastran, abaqus, matrices, superelement, rigid, "
        "reduced, section_table; this one",
    ),
    "no mesh": ('mesh = "blade.inp"\n', "", 'body[1]: a shell body needs a mesh; add mesh = "FILE.inp"'),
    "a mesh for a rigid body": (
        "rigid = {",
        'mesh = "blade.inp"\nrigid = {',
        "body[2].mesh: a rigid body takes no mesh",
    ),
    "a frame for a rigid body": (
        "rigid = {",
        'frame = {kind = "nodal-fixed", interface = "flange"}\nrigid = {',
        "body[2].frame: a rigid body takes no frame; remove the key",
    ),
    "no frame": (
        'frame = { kind = "mean-axis" }\n',
        "",
        "body[1]: a shell body needs frame; for example frame = {",
    ),
    "nodes of a rigid body": (
        "position = [0, 0, -1.5]",
        'nodes = "X"',
        "a rigid body has no nodes; give position",
    ),
    "no position": (
        "position = [0, 0, -1.5]",
        "",
        "interface[1]: an interface of a rigid body needs position =",
    ),
    "no nodes": (
        'nodes = "TIP"',
        "",
        "interface[2]: an interface needs one of nodes (a node set's name), node_indices",
    ),
    "repeated body name": (
        'name = "hub"',
        'name = "blade"',
        "an earlier body is already named 'blade'; names must differ",
    ),
    "repeated interface name": (
        'name = "tip"',
        'name = "root"',
        "an earlier interface is already named 'root'; names must",
    ),
    "dot in a name": (
        'name = "hub"',
        'name = "h.ub"',
        "'h.ub' cannot be a body name: no dots, and not the word gr",
    ),
    "frame at an unknown interface": (
        '"mean-axis"',
        '"nodal-fixed", interface = "rot"',
        "frame.interface: there is no interface named 'rot', did you mean 'root'?; there is: root, tip",
    ),
    "joint without axis": (
        "axis = [1, 0, 0]\n",
        "",
        "joint[1]: a prescribed-rotation joint needs axis; add axis =",
    ),
    "joint with a needless axis": (
        'kind = "fixed"',
        'kind = "ball"\naxis = [1, 0, 0]',
        "a ball joint takes no axis",
    ),
    "a weld with an axis of length zero": (
        'kind = "fixed"',
        'kind = "fixed"\nx_axis = [0, 0, 0]',
        "joint[2].x_axis: an axis of length zero has no dir",
    ),
    "axis of length zero": (
        "axis = [1, 0, 0]",
        "axis = [0, 0, 0]",
        "joint[1].axis: an axis of length zero has no dir",
    ),
    "unknown end": (
        'second = "blade.root"',
        'second = "blade.rot"',
        "no interface of 'blade' named 'rot', did you",
    ),
    "unknown body": (
        'second = "blade.root"',
        'second = "blde.root"',
        "no body named 'blde', did you mean 'blade'?",
    ),
    "end without a dot": (
        'first = "hub.flange"',
        'first = "grund"',
        "'grund' is not ground or BODY.INTERFACE, did you",
    ),
    "ground second": (
        'second = "blade.tip"',
        'second = "ground"',
        "spring[1].second: ground is not allowed here, only as first end",
    ),
    "a spring from nowhere on the ground": (
        'kind = "straight"\nfirst = "hub.flange"',
        'kind = "straight"\nfirst = "ground"',
        "spring[1]: SpringDamper on ground: an end on the ground, and only such an end, needs an anchor",
    ),
    "a torque on a node set": (
        'kind = "force"\nat = "blade.LE"',
        'kind = "torque"\nat = "blade.LE"',
        "load[1].at: a torque or a follower load needs",
    ),
    "a follower on a node set": (
        'at = "blade.LE"',
        'at = "blade.LE"\nfollower = true',
        "a torque or a follower load",
    ),
    "damping of modes held nowhere": (
        "modes = [1, 2]",
        'held = "rot"',
        "damping.held: there is no interface named",
    ),
    "load on nothing": (
        'at = "blade.LE"',
        'at = "hub.LE"',
        "load[1].at: there is no interface of 'hub' named 'LE'",
    ),
    "track of nothing": (
        '"blade.TE"]',
        '"hub.TE"]',
        "output.track[2]: there is no interface of 'hub' named 'TE'",
    ),
    "two step rules": (
        "step = 0.02\n\n",
        "step = 0.02\nadaptive = {first = 1e-6, largest = 0.01}\n\n",
        "give either step = TIME or adaptive = {first = .., largest = ..}, not both or none",
    ),
    "a first step too long": (
        "step = 0.02\n\n",
        "adaptive = {first = 0.1, largest = 0.01}\n\n",
        "simulation.adaptive.first: the first step, 0.1, exceeds the largest, 0.01",
    ),
    "output step too long": (
        "output_step = 0.02",
        "output_step = 21.0",
        "21.0 is longer than the duration, 20",
    ),
    "output step does not divide": (
        "output_step = 0.02",
        "output_step = 0.03",
        "is not a multiple of 0.03; try 0.02",
    ),
    "derivatives of a linear body": (
        'frame = { kind = "mean-axis" }\nreduction = { basis',
        'linear = true\nframe = { kind = "mean-axis" }\nreduction = { basis',
        "reduction.derivatives: a linear body has no modal derivatives; remove the key",
    ),
    "modal damping of a full body": (
        'reduction = { basis = "rubin", modes = 10, derivatives = { kind = "picked", number = 5 } }\n'
        'damping = { kind = "rayleigh-ratio", ratio = 0.02, modes = [1, 2] }',
        'reduction = { basis = "none" }\ndamping = { kind = "modal", ratio = 0.02 }',
        "damping.kind: a body that is not reduced takes rayleigh or rayleigh-ratio damping",
    ),
    "modal damping of a reduction that corrects itself": (
        f"{SIZES}\n{DAMPING}",
        'damping = { kind = "modal", ratio = 0.02 }',
        "damping.kind: a reduction that corrects itself takes rayleigh or rayleigh-ratio damping, or modal",
    ),
    "derivatives without modes": (
        "modes = 10, ",
        "",
        "reduction.derivatives: derivatives need modes = 10, for a basis of fixed size, or accuracy",
    ),
    "two errors to reach": (
        "modes = 10, ",
        "accuracy = { relative = 1e-3, absolute = 1e-3 }, ",
        "reduction.accuracy.absolute: give the error either as relative or as absolute (a length), not both",
    ),
    "an error of nothing": (
        "modes = 10, ",
        "accuracy = { relative = 0.0 }, ",
        "accuracy.relative: should be greater than 0, got 0.0 (largest RMS error",
    ),
    "a tolerance that is no share": (
        SIZES,
        'reduction = { basis = "error-controlled", tolerance = 1.0, modes = 10 }',
        "reduction.tolerance: should be less than 1, got 1.0 (largest relative error of the eigenvalues,",
    ),
    "a tolerance below round-off": (
        SIZES,
        'reduction = { basis = "error-controlled", tolerance = 1e-9, modes = 10 }',
        "reduction.tolerance: should be greater than or equal to 0.0000001, got 1e-09 (largest",
    ),
    "a tolerance of an unknown number of eigenvalues": (
        SIZES,
        'reduction = { basis = "error-controlled", tolerance = 1e-3 }',
        "reduction.modes: this key is missing; add it (number of lowest elastic eigenvalues within",
    ),
    "two kinds of accuracy": (
        SIZES,
        'reduction = { basis = "error-controlled", tolerance = 1e-3, modes = 9, accuracy = {} }',
        "reduction.accuracy: unknown key; known keys: basis, tolerance, modes, attachment_modes, derivatives",
    ),
    "an unknown selection": (
        'basis = "rubin"',
        'basis = "craig-bampton", select = "coupling"',
        "reduction.select: 'coupling' is not known, did you mean 'coupling-moment'?; choose one of",
    ),
    "candidates of no selection": (
        'basis = "rubin"',
        'basis = "craig-bampton", candidates = 40',
        "reduction.candidates: the lowest modes are kept by default; remove the key, or add",
    ),
    "too few candidates": (
        'basis = "rubin"',
        'basis = "craig-bampton", select = "coupling-moment", candidates = 9',
        "reduction.candidates: 10 modes cannot be selected among 9 candidates; give more",
    ),
    "twice the same mode": (
        "modes = [1, 2]",
        "modes = [2, 2]",
        "give two different mode numbers from 1, for exam",
    ),
    "no such file": ('"blade.inp"', '"blad.inp"', "body[1].mesh: there is no file"),
    "not a mesh file": (
        '"blade.inp"',
        '"blade.txt"',
        "'blade.txt' is not a readable mesh; give a file .inp or .msh",
    ),
    "a table file that is not there": (
        '"ramp", value = 1, duration = 2.0',
        '"table", file = "t.csv"',
        "law.file: there is",
    ),
}


@pytest.mark.parametrize(("old", "new", "message"), ONE_MISTAKE.values(), ids=ONE_MISTAKE.keys())
def test_each_mistake_is_named_at_its_key_or_at_the_table_it_is_missing_from(folder, old, new, message):
    row = next(row for row in mistakes(folder, GOOD.replace(old, new, 1)).splitlines() if message in row)
    start = GOOD[: GOOD.index(old)].count("\n") + 1
    headers = [number for number, text in enumerate(GOOD.splitlines(), 1) if text.startswith("[")]
    header = max((number for number in headers if number <= start), default=1)
    assert header <= int(row.split()[1].rstrip(",")) <= start + new.count("\n")


WRONG = {
    "name of a body": ('name = "hub"', "name = [1]", "name"),
    "name of a spring": ("[[spring]]\n", "[[element]]\nname = []\n[[spring]]\nname = {}\n", "name"),
    "place of a follower": ('at = "blade.LE"', "follower = true\nat = [1]", "at"),
    "modes of a damping": ("modes = [1, 2]", 'modes = ["a", 2]', "modes"),
    "body of a tie": ("[[spring]]\n", "[[tie]]\nnodes = [1]\non = [2]\n[[spring]]\n", "on"),
}


@pytest.mark.parametrize(("old", "new", "key"), WRONG.values(), ids=WRONG.keys())
def test_a_value_of_a_wrong_type_is_a_mistake_and_no_fault_of_a_rule(folder, old, new, key):
    assert old in GOOD
    assert key in mistakes(folder, GOOD.replace(old, new))


def test_the_line_is_that_of_the_key(folder):
    text = GOOD.replace("thickness = 0.02", "thicknes = 0.02")
    assert f"line {line_of(text, 'thicknes =')}, body[1].shell.thicknes:" in mistakes(folder, text)


def test_all_mistakes_come_at_once_in_the_order_of_the_file(folder):
    text = GOOD
    for name in (
        "unknown key",
        "unknown end",
        "no frame",
        "output step too long",
        "out of range",
        "load on nothing",
    ):
        old, new, _ = ONE_MISTAKE[name]
        text = text.replace(old, new, 1)
    report = mistakes(folder, text)
    # The unknown thickness is a missing one too.
    assert "has 7 mistakes" in report
    lines = [int(row.split()[1].rstrip(",")) for row in report.splitlines()[1:]]
    assert lines == sorted(lines)


def test_one_mistake_is_counted_as_one(folder):
    assert "case.toml has one mistake:" in mistakes(folder, GOOD.replace('"fixed"', '"fixd"'))


SUPERELEMENT = """\
title = "t"
[[body]]
name = "s"
superelement = { stiffness = "k.mtx", mass = "m.mtx", nodes = "nodes.csv", dofs_per_node = 6 }
frame = { kind = "mean-axis" }
reduction = { basis = "none" }
[[body.interface]]
name = "a"
node_indices = [0, 3]
[simulation]
duration = 1
output_step = 0.1
step = 0.1
"""


def test_a_superelement_names_nodes_by_number(folder):
    assert read(folder, SUPERELEMENT).tables.body[0].interface[0].node_indices == (0, 3)
    report = mistakes(folder, SUPERELEMENT.replace("node_indices = [0, 3]", 'nodes = "A"'))
    assert "line 9, body[1].interface[1].nodes: a superelement has no node sets; give node_indices" in report


def test_a_basis_of_interface_shapes_needs_an_interface(folder):
    interface = '[[body.interface]]\nname = "a"\nnode_indices = [0, 3]\n'
    controlled = SUPERELEMENT.replace(
        'basis = "none"', 'basis = "error-controlled", tolerance = 0.1, modes = 3'
    )
    read(folder, controlled)
    report = mistakes(folder, controlled.replace(interface, ""))
    assert "line 6, body[1].reduction.basis: error-controlled needs an interface; add [[body.in" in report
    read(folder, SUPERELEMENT.replace(interface, "").replace('"none"', '"normal-modes"'))


def test_a_case_without_elements_has_no_stress_to_show(folder):
    coloured = SUPERELEMENT + '[output]\ncolour = "von-mises"\n'
    assert (
        "line 15, output.colour: no body has elements whose stress could be shown (shell, solid, nastran, "
        "abaqus, section_table)" in mistakes(folder, coloured)
    )
    read(folder, coloured.replace("von-mises", "deflection"))


def test_a_missing_matrix_file_is_named(folder):
    assert "body[1].superelement.mass: there is no file" in mistakes(
        folder, SUPERELEMENT.replace("m.mtx", "n.mtx")
    )


def test_no_step_rule(folder):
    assert "line 10, simulation: give either step" in mistakes(
        folder, SUPERELEMENT.replace("\nstep = 0.1", "")
    )


def test_a_case_without_bodies(folder):
    report = mistakes(
        folder, 'title = "t"\nbody = []\nsimulation = {duration = 1, output_step = 1, step = 1}\n'
    )
    assert "line 2, body: a case needs at least one [[body]]" in report


def test_a_text_that_is_not_toml_names_the_line(folder):
    assert "is not valid TOML" in (report := mistakes(folder, "title = one blade\n"))
    assert "line 1" in report


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(
        CaseError, match=r"cannot read the case file .*: No such file or directory; check the path"
    ):
        read_case(tmp_path / "nothing.toml")


def test_a_file_that_is_not_text(tmp_path):
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(CaseError, match="is not a text file in UTF-8"):
        read_case(tmp_path / "picture.toml")


def test_mistakes_found_after_reading_carry_their_line(folder):
    case = read(folder, GOOD)
    error = case.error([(("body", 0, "interface", 1, "nodes"), "there is no node set named 'TIP'")])
    line = line_of(GOOD, "TIP")
    assert f"line {line}, body[1].interface[2].nodes: there is no node set" in str(error)

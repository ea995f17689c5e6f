"""Slender bodies in case files: from a mesh to motion, pictures and a film; mistakes are named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from supple.cases import modes_case, read_case, run_case, static_case
from supple.errors import CaseError, ModelError, SuppleWarning
from supple.methods.intrinsic import CLAMPED, IntrinsicBody, intrinsic_body

WING = Path(__file__).parents[2] / "examples" / "wing.toml"
WHOLE = [
    'frame = { kind = "mean-axis" }\n',
    'reduction = { basis = "rubin", modes = 4, derivatives = { kind = "compressed", number = 3 } }\n',
]
CONDENSE = 'condense = { root = "root", tip = "tip", stations = 5, modes = 4 }\n'
TIP = '[[body.interface]]\nname = "tip"\nnodes = "TIP"\nkind = "averaging"\n\n[[joint]]'


def rewritten(folder, *changes):
    path = folder / "strip.toml"
    text = path.read_text()
    for old in WHOLE:
        text = text.replace(old, "")
    text = text.replace("damping = {", CONDENSE + "damping = {").replace("[[joint]]", TIP)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


@pytest.mark.slow
def test_a_condensed_strip_swings_as_the_whole_one(case_folder, tmp_path):
    """Under its weight, small enough that a floating frame is right as well."""
    whole = run_case(read_case(case_folder / "strip.toml"), tmp_path / "whole").tracked["strip.TIP"]
    result = run_case(read_case(rewritten(case_folder)), tmp_path / "condensed")
    assert isinstance(result.system.bodies[0].body, IntrinsicBody)
    tip = result.tracked["strip.TIP"]
    sag = np.ptp(whole.position[:, 2])
    assert np.abs(tip.position - whole.position).max() < 0.03 * sag
    assert tip.deflection[-1] == pytest.approx(tip.position[-1] - tip.position[0], abs=1e-9)
    report = json.loads((tmp_path / "condensed" / "strip.json").read_text())
    assert report["bodies"]["strip"]["kind"] == "intrinsic"
    assert report["bodies"]["strip"]["stations"] == 5


@pytest.mark.slow
def test_a_requested_error_of_a_basis_that_is_not_estimated_is_warned_of(case_folder, tmp_path):
    """Of the reduced strip beside the condensed one, whose omitted modes are estimated."""
    path = case_folder / "strip.toml"
    text = path.read_text().replace("duration = 0.4", "duration = 0.004")
    head, rest = text.split("[simulation]")
    body, joint = head[head.index("[[body]]") :].split("[[joint]]")
    for old in WHOLE:
        body = body.replace(old, "")
    body = body.replace("damping = {", CONDENSE.replace(" }", ", released = true }") + "damping = {")
    other = (body + TIP + joint).replace('"strip"', '"arm"').replace("strip.root", "arm.root")
    asked = "[error]\nbasis = true\nintegration = false\n"
    path.write_text(f"{head}{other.replace('clamp', 'clasp')}{asked}[simulation]{rest}")
    with pytest.warns(SuppleWarning, match=r"basis = true: .* of 'strip' is not estimated: .* intrinsic"):
        solution = run_case(read_case(path), tmp_path / "out").solution
    assert solution.errors["strip"].basis is None
    assert solution.errors["arm"].basis is not None


def test_a_condensed_strip_rests_as_a_cantilever_under_its_weight(case_folder, tmp_path):
    """Its tip sags by w L^4 / (8 E I), but for the two hundredths of eight elements and five stations."""
    path = rewritten(case_folder, (", modes = 4", ""))
    found = static_case(read_case(path), tmp_path / "rest", errors=False)
    sag = 7850.0 * 0.01 * 9.81 / (8 * 2.1e11 * 0.01**3 / 12)
    assert found.tracked["strip.TIP"].position[0, 2] == pytest.approx(-sag, rel=0.02)


@pytest.mark.slow
def test_as_many_modes_are_kept_as_an_accuracy_takes(case_folder, tmp_path):
    path = rewritten(
        case_folder, ("modes = 4", "accuracy = { relative = 0.02 }"), ("duration = 0.4", "duration = 0.1")
    )
    result = run_case(read_case(path), tmp_path / "enough")
    (stated,) = result.solution.errors.values()
    assert 0 < stated.basis.value <= 0.02 * stated.size or "all modes" in stated.basis.how


@pytest.mark.slow
def test_stress_and_pictures_are_those_of_any_body(case_folder, tmp_path):
    path = rewritten(
        case_folder,
        ("duration = 0.4", "duration = 0.02"),
        ("pictures = false", 'colour = "von-mises"'),
        ("animation = false\n", ""),
    )
    run_case(read_case(path), tmp_path / "drawn")
    drawn = {file.name for file in (tmp_path / "drawn").iterdir()}
    assert {"motion.gif", "strip-modes.png", "strip-deformed.png", "strip-stress.png", "machine.png"} <= drawn


def test_the_wing_is_a_valid_case():
    (body,) = read_case(WING).tables.body
    assert body.condense is not None
    assert body.condense.stations == 21


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('tip = "tip"', 'tip = "top"', "there is no interface named 'top', did you mean 'tip'"),
        ("modes = 4", 'modes = 4, support = "hinged"', "a hinged root needs body_axis"),
        (
            "modes = 4",
            'modes = 4, support = "released"',
            "'released' is not known; choose one of clamped, free",
        ),
        ("modes = 4", 'modes = 4, support = ["ball"]', "condense.support: "),
        ("modes = 4", "modes = 4, body_axis = [0, 0, 1]", "only a hinged or sliding root has a body_axis"),
        ("modes = 4", 'modes = 4, support = "hinged", axis = [0, 0, 1]', "axis is now body_axis"),
        (CONDENSE, CONDENSE + WHOLE[0], "takes no frame; remove the key"),
        ('kind = "rayleigh"', 'kind = "linear-rayleigh"', 'takes damping of kind "rayleigh" or "modal"'),
        (
            "damping = {",
            'damping = { held = "root",',
            "a condensed body acts on its modes, not relative to an interface; remove held",
        ),
        ("stations = 5", "stations = 1", "greater than or equal to 2"),
        ("modes = 4", "modes = 4, accuracy = {}", "give either modes or accuracy, not both"),
    ],
)
def test_mistakes_are_named(case_folder, old, new, message):
    path = rewritten(case_folder, (old, new))
    with pytest.raises(CaseError, match=message):
        read_case(path)


RELEASED = CONDENSE.replace("modes = 4", "modes = 4, released = true")
HUB = """\
[[body]]
name = "hub"
rigid = { mass = 2.0, inertia = [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]] }

[[body.interface]]
name = "axle"
position = [0, 0, 0]

[[body.interface]]
name = "flange"
position = [0.1, 0, 0]

[[joint]]
name = "shaft"
kind = "revolute"
first = "ground"
second = "hub.axle"
axis = [0, 1, 0]

[[load]]
kind = "torque"
at = "hub.axle"
vector = [0, 20.0, 0]

"""
ON_HUB = (
    ('first = "ground"\nsecond = "strip.root"', 'first = "hub.flange"\nsecond = "strip.root"'),
    ("damping = {", "position = [0.1, 0, 0]\ndamping = {"),
    ('[[joint]]\nname = "clamp"', HUB + '[[joint]]\nname = "clamp"'),
    ("duration = 0.4", "duration = 0.1"),
)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_a_strip_on_a_turning_hub_moves_as_the_whole_one(case_folder, tmp_path):
    """Bent little, so that a floating frame is right as well, and turned by a motor on the hub."""
    path = case_folder / "strip.toml"
    text = path.read_text().replace("[[joint]]", TIP, 1)
    for old, new in ON_HUB:
        text = text.replace(old, new, 1)
    path.write_text(text)
    whole = run_case(read_case(path), tmp_path / "whole", errors=False)
    body = text.replace(WHOLE[0], "").replace(WHOLE[1], RELEASED)
    path.write_text(body)
    joined = run_case(read_case(path), tmp_path / "joined", errors=False)
    strip = joined.system.bodies[0].body
    assert isinstance(strip, IntrinsicBody)
    assert strip.modes.n_rigid == 6
    own, other = (result.tracked["strip.TIP"].position for result in (joined, whole))
    assert np.abs(own - other).max() < 5e-3 * np.ptp(other[:, 2])
    forces = [result.solution.joint_forces["clamp"][-1] for result in (joined, whole)]
    assert np.abs(forces[0] - forces[1]).max() < 0.05 * np.abs(forces[1]).max()


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_a_strip_hangs_by_its_tip_once_it_is_released(case_folder, tmp_path):
    """Still there where a joint holds it, and falling about that point as a rigid rod does at first."""
    path = rewritten(
        case_folder,
        (CONDENSE, RELEASED),
        ('kind = "fixed"', 'kind = "ball"'),
        ('second = "strip.root"', 'second = "strip.tip"'),
        ("duration = 0.4", "duration = 0.05"),
    )
    result = run_case(read_case(path), tmp_path / "hung", errors=False)
    held = result.tracked["strip.TIP"].position
    assert np.abs(held - held[0]).max() < 1e-6
    fallen = result.tracked["strip.root"].position[-1, 2]
    assert fallen == pytest.approx(-1.5 * 9.81 * 0.05**2 / 2, rel=0.02)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (ON_HUB, "one end is 'hub.flange': set released = true in its condense"),
        ((('second = "strip.root"', 'second = "strip.tip"'),), "'strip.tip': set released = true"),
        ((('kind = "fixed"', 'kind = "ball"'),), 'does not fit a clamped root: set support = "ball", or'),
        ((("modes = 4", 'modes = 4, support = "ball"'),), "a fixed joint does not fit a ball root"),
        ((('[[joint]]\nname = "clamp"', '[[spring]]\nname = "clamp"'),), "no joint supports 'strip'"),
        ((("step = 0.002\n\n", "adaptive = { first = 1e-3, largest = 1e-2 }\n\n"),), "give step = TIME"),
        (
            (("[simulation]", "[simulation]\nkinematic = true"),),
            "condensed body 'strip': make it a rigid body",
        ),
    ],
)
def test_what_a_condensed_body_cannot_do_is_named_before_anything_runs(case_folder, changes, message):
    path = rewritten(case_folder, *changes)
    with pytest.raises(CaseError, match=message):
        read_case(path)


def beside(case_folder, reduction):
    """A condensed strip clamped at its root, and one in a floating frame on its tip."""
    path = rewritten(case_folder, (CONDENSE, RELEASED), ("duration = 0.4", "duration = 0.004"))
    text = path.read_text()
    first, rest = text.split("[[joint]]", 1)
    whole = first[first.index("[[body]]") :].replace(RELEASED, WHOLE[0] + reduction)
    second = whole.replace('name = "strip"', 'name = "other"\nposition = [1, 0, 0]')
    weld = '[[joint]]\nname = "weld"\nkind = "fixed"\nfirst = "strip.tip"\nsecond = "other.root"\n\n'
    path.write_text(first + second + weld + "[[joint]]" + rest)
    return read_case(path)


@pytest.mark.filterwarnings("ignore::supple.errors.ValidityWarning")  # few modes, on purpose
@pytest.mark.slow
def test_beside_a_condensed_body_errors_are_of_its_modes_and_of_the_steps(case_folder, tmp_path):
    result = run_case(beside(case_folder, WHOLE[1]), tmp_path / "both")
    stated = result.solution.errors
    assert set(stated) == {"strip", "other"}
    assert stated["strip"].basis.value > 0
    assert stated["other"].basis is None
    assert all(each.step is not None and each.step.value > 0 for each in stated.values())


def test_beside_a_condensed_body_none_corrects_itself(case_folder, tmp_path):
    with pytest.raises(ModelError, match="give the other bodies reductions of fixed size"):
        run_case(beside(case_folder, ""), tmp_path / "both")


@pytest.mark.slow
@pytest.mark.parametrize("condense", [CONDENSE, RELEASED], ids=["held", "joined"])
def test_rest_and_modes_of_a_condensed_strip(case_folder, tmp_path, condense):
    """A run that starts in the equilibrium stays where `static` has it; modes swing about it."""
    path = rewritten(
        case_folder,
        (CONDENSE, condense),
        ("[simulation]", '[simulation]\nstart = "equilibrium"'),
        ("duration = 0.4", "duration = 0.02"),
    )
    case = read_case(path)
    rest = static_case(case, tmp_path / "rest")
    assert rest.numbers["stable"]
    run = run_case(case, tmp_path / "run", errors=False)
    own, moved = rest.tracked["strip.TIP"].position[0], run.tracked["strip.TIP"].position
    assert own[2] < -1e-5
    assert moved == pytest.approx(np.broadcast_to(own, moved.shape), abs=1e-9)
    modes, numbers = modes_case(case, tmp_path / "modes", n_modes=40)
    line = modes.machine.system.bodies[0].body.line
    lowest = intrinsic_body(line, CLAMPED).lowest_frequency()
    swinging = modes.eigenvalues[modes.frequencies > 0]
    assert abs(swinging[0]) == pytest.approx(lowest, rel=0.02)
    assert numbers["modes"][0]["kinetic_share"] == {"strip": pytest.approx(1.0)}
    assert not numbers["modes"][0]["unstable"]


def test_a_released_body_may_name_an_accuracy(case_folder):
    """Where joints connect bodies the modes left out are estimated as well."""
    path = rewritten(case_folder, ("modes = 4", "accuracy = { relative = 0.02 }, released = true"))
    (body,) = read_case(path).tables.body
    assert body.condense is not None
    assert body.condense.accuracy is not None

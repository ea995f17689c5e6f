"""Slender bodies in case files: from a mesh to motion, pictures and a film; mistakes are named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from supple.cases import read_case, run_case
from supple.errors import CaseError
from supple.intrinsic import IntrinsicBody

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
        ("modes = 4", 'modes = 4, support = "hinged"', "a hinged root needs axis"),
        ("modes = 4", "modes = 4, axis = [0, 0, 1]", "only a hinged or sliding root has an axis"),
        (CONDENSE, CONDENSE + WHOLE[0], "takes no frame; remove the key"),
        ('kind = "rayleigh"', 'kind = "linear-rayleigh"', 'takes damping of kind "rayleigh" or "modal"'),
        ("stations = 5", "stations = 1", "greater than or equal to 2"),
    ],
)
def test_mistakes_are_named(case_folder, old, new, message):
    path = rewritten(case_folder, (old, new))
    with pytest.raises(CaseError, match=message):
        read_case(path)

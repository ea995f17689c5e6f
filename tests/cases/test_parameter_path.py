"""Paths of the numbers of a case file: by name, by position, and what leads nowhere."""

from __future__ import annotations

import pytest

from supple.cases.parameter_path import parameter_path, with_value
from supple.errors import CaseError

RAW = {
    "gravity": [0.0, 0.0, -9.81],
    "body": [{"name": "hub", "rigid": {"mass": 1.0}}, {"name": "blade", "shell": {"thickness": 0.02}}],
    "joint": [
        {"name": "blade root", "kind": "fixed", "first": "ground", "second": "hub.axle"},
        {"kind": "revolute", "first": "hub.flange", "second": "blade.root", "axis": [1, 0, 0]},
    ],
    "load": [{"kind": "force", "law": {"kind": "sine", "amplitude": 2.0}}],
}


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("gravity[2]", ("gravity", 2)),
        ("body.blade.shell.thickness", ("body", 1, "shell", "thickness")),
        ("body[0].rigid.mass", ("body", 0, "rigid", "mass")),
        ("joint.blade root.kind", ("joint", 0, "kind")),
        ("joint.revolute hub.flange - blade.root.axis[2]", ("joint", 1, "axis", 2)),
        ("load[0].law.amplitude", ("load", 0, "law", "amplitude")),
        ("load[0].follower", ("load", 0, "follower")),  # which has a default
    ],
)
def test_a_path_leads_to_a_place(text, place):
    assert parameter_path(text, RAW) == place


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "body.blad.shell.thickness",
            r"named 'blad', did you mean 'blade'\?; names: hub, blade",
        ),
        ("load[1].law", r"there is no item \[1\]"),
        ("loads[0].law", r"there is no 'loads', did you mean 'load'\?"),
        ("body.blade.shel.thickness", r"did you mean 'shell'"),
        ("body.hub.rigid.mass.unit", r"there is nothing below body\.0\.rigid\.mass"),
        ("[0]", "not a path of a case file"),
        ("", "an empty path"),
    ],
)
def test_a_path_that_leads_nowhere_is_refused(text, message):
    with pytest.raises(CaseError, match=message):
        parameter_path(text, RAW)


def test_another_value_leaves_the_tables_alone():
    changed = with_value(RAW, ("body", 1, "shell", "thickness"), 0.03)
    assert changed["body"][1]["shell"]["thickness"] == 0.03
    assert RAW["body"][1]["shell"]["thickness"] == 0.02
    assert changed["body"][0] is RAW["body"][0]

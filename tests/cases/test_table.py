"""A table made from a class: its keys, what they refuse, and what they build."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from pydantic import Field, ValidationError

from supple.arguments import NotNegative, Positive
from supple.cases.table import Key, Made, OneOf, named_in, part, table_of
from supple.importers.toml import CheckedTable


@dataclass(frozen=True)
class Rim:
    """The outside of a wheel.

    width : a length
    """

    width: Positive


@dataclass(frozen=True)
class Wheel:
    """Rolls.

    radius : a length, of the tyre;
        half of what is called its size        hub : place of the centre, global axes
    """

    radius: Positive
    hub: tuple[float, float, float]
    rim: Any = None
    slip: NotNegative | None = 0.5
    limit: float = np.inf
    spokes: tuple[float, ...] = field(default_factory=lambda: (1.0,))
    cache: Any = 7


class Drives(Made):
    """What all tables of the section share."""

    at: Annotated[str, "interface"]


TABLE = table_of(
    Wheel,
    "wheel",
    Drives,
    hub=Key(name="centre", through=lambda centre, folder: (*centre[:2], float(folder.name))),
    rim=part(Rim, width=Key(name="rim_width", default=None)),
    cache=None,
)
GIVEN = {"kind": "wheel", "at": "car.axle", "radius": 0.3, "centre": [1.0, 2.0, 3.0]}


def test_keys_are_the_parameters_but_for_what_is_said_by_hand():
    keys = TABLE.model_fields
    assert list(keys) == ["at", "kind", "radius", "centre", "rim_width", "slip", "limit", "spokes"]
    assert keys["radius"].description == "a length, of the tyre; half of what is called its size"
    assert keys["centre"].description == "place of the centre, global axes"
    assert keys["rim_width"].description == "a length"
    assert [key for key, own in keys.items() if own.is_required()] == ["at", "kind", "radius", "centre"]
    assert TABLE.__doc__ == "Rolls."


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ({"radius": 0.0}, "greater_than"),
        ({"slip": -0.1}, "greater_than_equal"),
        ({"centre": [1.0, 2.0]}, "missing"),
        ({"radius": "0.3"}, "float_type"),
        ({"cache": 8}, "extra_forbidden"),
    ],
)
def test_types_and_ranges_are_those_of_the_class(changed, error):
    with pytest.raises(ValidationError) as seen:
        TABLE.model_validate(GIVEN | changed)
    assert [each["type"] for each in seen.value.errors()] == [error]


def test_it_builds_what_a_script_would_write():
    """None is an argument where the class takes it, and else the class's own default."""
    folder = Path("7")
    assert TABLE.model_validate(GIVEN).build(folder) == Wheel(0.3, (1.0, 2.0, 7.0))
    given = TABLE.model_validate(GIVEN | {"rim_width": 0.2, "slip": None, "limit": None})
    assert given.build(folder) == Wheel(0.3, (1.0, 2.0, 7.0), Rim(0.2), None)


def test_a_parameter_that_the_class_lacks_is_refused():
    with pytest.raises(TypeError, match="Wheel has no parameter tyre"):
        table_of(Wheel, "wheel", tyre=Key())


def test_what_a_file_names_is_found_also_where_other_keys_are_wrong():
    class Case(CheckedTable):
        part: Annotated[tuple[Annotated[Drives, OneOf(TABLE)], ...], Field(strict=False)] = ()
        track: Annotated[tuple[Annotated[str, "node set"], ...], Field(strict=False)] = ()
        mesh: Annotated[str, "file"] | None = None

    raw = {
        "part": [GIVEN | {"radius": -1}, {"kind": "whel", "at": 3}],
        "track": ["car.TOP"],
        "mesh": "car.inp",
    }
    assert list(named_in(Case, raw)) == [
        (("part", 0, "at"), "car.axle", "interface"),
        (("part", 1, "at"), 3, "interface"),
        (("track", 0), "car.TOP", "node set"),
        (("mesh",), "car.inp", "file"),
    ]

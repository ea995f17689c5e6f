"""The steady rotation of a case, for its equilibrium and its modes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from supple.cases.shared_rules import axes_with_length
from supple.cases.table import Key, table_of
from supple.importers.toml import ZERO, Mistakes, Raw, Vector, names, table
from supple.machine import Spin

_NAMES = Annotated[tuple[str, ...], Field(strict=False)]


class SpinTable(
    table_of(
        Spin,
        rate=Key(float, "angular velocity, rad per time"),
        axis=Key(Vector, "direction of the axis, global axes, not zero", default=...),
        point=Key(Vector, "point on the axis, global axes, a length", default=ZERO),
        bodies=Key(_NAMES, "names of the rotating bodies; default: all"),
    )
):
    """The steady rotation in `supple static`, in `supple modes`, and of runs that start in equilibrium."""


def _spinning_bodies_exist(raw: Raw) -> Mistakes:
    named = table(raw, "spin").get("bodies")
    known = names(raw, "body")
    for name in named if isinstance(named, list) else ():
        if name not in known:
            yield ("spin", "bodies"), f"there is no body '{name}'; there are: {', '.join(known)}"


RULES = (lambda raw: axes_with_length(("spin",), table(raw, "spin")), _spinning_bodies_exist)

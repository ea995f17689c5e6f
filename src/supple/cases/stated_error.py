"""What is stated of the error of a case: which parts are looked at, and in which quantities."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from supple.cases.body_kinds import at_elements
from supple.cases.shared_rules import PlaceOf, joint_names
from supple.fem import FiniteElementModel
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, table, tables, unknown
from supple.quantities import Deflection, JointForce, JudgedQuantity
from supple.quantities.judged_stress import JudgedStress

Place = Callable[[str], tuple[str, Any]]
"""The body of BODY.PLACE, and its interface or the nodes of its node set."""


class DeflectionOf(CheckedTable):
    """Positions of an interface, or of the nodes of a set."""

    kind: Literal["deflection"]
    at: PlaceOf = Field(description="BODY.INTERFACE or BODY.NODE_SET")

    def quantity(self, place: Place, _: Mapping[str, FiniteElementModel]) -> JudgedQuantity:
        """What is judged."""
        body, where = place(self.at)
        return Deflection(body, where if isinstance(where, str) else tuple(where), self.at)


class StressOf(CheckedTable):
    """Von Mises stress at the nodes of a set."""

    kind: Literal["stress"]
    at: PlaceOf = Field(description="BODY.NODE_SET")

    def quantity(self, place: Place, elements: Mapping[str, FiniteElementModel]) -> JudgedQuantity:
        """What is judged."""
        body, where = place(self.at)
        return JudgedStress(body, elements[body], where, self.at)


class JointForceOf(CheckedTable):
    """Force of a joint."""

    kind: Literal["joint-force"]
    joint: str = Field(description="its name")

    def quantity(self, _: Place, __: Mapping[str, FiniteElementModel]) -> JudgedQuantity:
        """What is judged."""
        return JointForce(self.joint)


Judged = Annotated[DeflectionOf | StressOf | JointForceOf, Field(discriminator="kind")]


class StatedError(CheckedTable):
    """Which parts of the error of a run are looked at, and in which quantities besides whole bodies."""

    basis: bool | None = Field(
        None,
        description="bodies of a fixed size, by the error equation or a richer run; false if left out",
    )
    integration: bool | None = Field(
        None,
        description="time step and Newton's tolerance, by two more runs; true if left out, but false where a "
        "body is not reduced",
    )
    model: bool = Field(True, description="elements and ties that turn against their frame")
    of: Annotated[tuple[Judged, ...], Field(strict=False)] = Field(
        (), description="quantities that are judged besides"
    )


def judged_places(raw: Raw) -> Iterator[tuple[KeyPath, Raw]]:
    """Every table of a quantity that is judged, and where it stands."""
    for position, each in enumerate(_listed(table(raw, "error").get("of"))):
        yield ("error", "of", position), each
    for path, body in tables(raw, "body"):
        of = table(table(table(body, "reduction"), "accuracy"), "of")
        if of:
            yield (*path, "reduction", "accuracy", "of"), of


def _listed(given: Any) -> list[Raw]:
    return [each for each in given if isinstance(each, dict)] if isinstance(given, list) else []


def _judged_joints_exist(raw: Raw) -> Mistakes:
    """The rule that a joint whose force is judged is there."""
    joints = joint_names(raw)
    for path, each in judged_places(raw):
        name = each.get("joint")
        if isinstance(name, str) and name not in joints:
            yield (*path, "joint"), unknown("joint", name, joints)


OF_STRESS = ("whose stress it would be", "stress is that of")
RULES = (
    _judged_joints_exist,
    lambda raw: at_elements(raw, judged_places(raw), {"stress": OF_STRESS}),
)

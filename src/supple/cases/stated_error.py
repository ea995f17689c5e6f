"""The error estimate of a case: which parts are estimated, and for which quantities."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Literal

from pydantic import Field

from supple.cases.body_kinds import at_elements
from supple.cases.shared_rules import PlaceOf, joint_names
from supple.fem import FiniteElementModel
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, table, tables, unknown
from supple.quantities import JointForceSensor, Place, PositionSensor, QuantityOfInterest, StressSensor

Elements = Mapping[str, FiniteElementModel]


class PositionOf(CheckedTable):
    """Positions of an interface, or of the nodes of a set."""

    kind: Literal["deflection"]
    at: PlaceOf = Field(description="BODY.INTERFACE or BODY.NODE_SET")

    def quantity(self, place: Callable[[str], Place], _: Elements) -> QuantityOfInterest:
        """The sensor."""
        return PositionSensor(self.at, place(self.at))


class StressOf(CheckedTable):
    """Von Mises stress at the nodes of a set."""

    kind: Literal["stress"]
    at: PlaceOf = Field(description="BODY.NODE_SET")

    def quantity(self, place: Callable[[str], Place], elements: Elements) -> QuantityOfInterest:
        """The sensor."""
        body, nodes = place(self.at).body, place(self.at).at
        assert not isinstance(nodes, str)  # by the rule on elements
        return StressSensor(f"stress at {self.at}", body, elements[body], nodes)


class JointForceOf(CheckedTable):
    """Force of a joint."""

    kind: Literal["joint-force"]
    joint: str = Field(description="name of the joint")

    def quantity(self, _: Callable[[str], Place], __: Elements) -> QuantityOfInterest:
        """The sensor."""
        return JointForceSensor(f"force of {self.joint}", self.joint)


OfInterest = Annotated[PositionOf | StressOf | JointForceOf, Field(discriminator="kind")]


class StatedError(CheckedTable):
    """The parts of the error of a run that are estimated, and the quantities of interest."""

    basis: bool | None = Field(
        None,
        description="error of bases of fixed size, by the error equation or a run with richer bases; default "
        "false",
    )
    integration: bool | None = Field(
        None,
        description="error of time step and Newton's tolerance, by two more runs; default true, false if a "
        "body is not reduced",
    )
    model: bool = Field(
        True, description="error caused by rotations of elements and ties relative to the frame of their body"
    )
    of: Annotated[tuple[OfInterest, ...], Field(strict=False)] = Field(
        (), description="further quantities of interest"
    )


def places_of_interest(raw: Raw) -> Iterator[tuple[KeyPath, Raw]]:
    """Every table of a quantity of interest, with its path."""
    for position, each in enumerate(_listed(table(raw, "error").get("of"))):
        yield ("error", "of", position), each
    for path, body in tables(raw, "body"):
        of = table(table(table(body, "reduction"), "accuracy"), "of")
        if of:
            yield (*path, "reduction", "accuracy", "of"), of


def _listed(given: object) -> list[Raw]:
    return [each for each in given if isinstance(each, dict)] if isinstance(given, list) else []


def _joints_exist(raw: Raw) -> Mistakes:
    """The rule that a joint of a quantity of interest exists."""
    joints = joint_names(raw)
    for path, each in places_of_interest(raw):
        name = each.get("joint")
        if isinstance(name, str) and name not in joints:
            yield (*path, "joint"), unknown("joint", name, joints)


OF_STRESS = ("whose stress could be computed", "stress is computed in")
RULES = (
    _joints_exist,
    lambda raw: at_elements(raw, places_of_interest(raw), {"stress": OF_STRESS}),
)

"""The sensors of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from supple import sensors
from supple.cases.body_kinds import kind_of, kinds_that
from supple.cases.shared_rules import usable_names
from supple.errors import ModelError
from supple.fem import FiniteElementModel
from supple.importers.toml import CheckedTable, KeyPath, Mistakes, Raw, Vector, names, tables, unknown
from supple.machine import At, ForceElement, as_end


class SensedCase(NamedTuple):
    """What sensors find in a case."""

    place: Callable[[str], tuple[str, Any]]
    """The body of BODY.PLACE, and its interface or the nodes of its node set."""
    bases: Mapping[str, At]
    """Interfaces from which the parts of split bodies are seen."""
    elements: Mapping[str, FiniteElementModel]
    springs: Mapping[str, ForceElement]
    """Those that have a name."""


def _place(case: SensedCase, at: str) -> sensors.Place:
    """The place that a sensor's `at` names."""
    body, where = case.place(at)
    return sensors.Place(body, where if isinstance(where, str) else tuple(np.asarray(where).tolist()))


class PlaceSensor(CheckedTable):
    """Where a place is, how it moves, or how it is deflected."""

    kind: Literal["position", "velocity", "acceleration", "deflection"]
    name: str = Field(description="its columns are NAME.x, NAME.y, ...")
    at: str = Field(description="BODY.INTERFACE or BODY.NODE_SET, whose mean is taken")
    seen_from: str | None = Field(
        None, description="deflection: BODY.INTERFACE; the body's first one if left out"
    )

    def build(self, case: SensedCase) -> sensors.Sensor:
        """The sensor."""
        at = _place(case, self.at)
        if self.kind == "deflection":
            base = case.bases.get(at.body) if self.seen_from is None else as_end(self.seen_from)
            return sensors.DeflectionSensor(self.name, at, base)
        kinds = {
            "position": sensors.PositionSensor,
            "velocity": sensors.VelocitySensor,
            "acceleration": sensors.AccelerationSensor,
        }
        return kinds[self.kind](self.name, at)


class JointSensor(CheckedTable):
    """How far a joint has turned and slid and how fast, or what it carries."""

    kind: Literal["joint-motion", "joint-force"]
    name: str = Field(description="its columns are NAME.angle, NAME.rate, ...; or NAME.Fx, ..., NAME.Mz")
    joint: str = Field(description="its name")

    def build(self, _: SensedCase) -> sensors.Sensor:
        """The sensor."""
        made = sensors.JointForceSensor if self.kind == "joint-force" else sensors.JointMotionSensor
        return made(self.name, self.joint)


_Component = Literal["von-mises", "principal", "xx", "yy", "zz", "yz", "xz", "xy"]


class TensorSensor(CheckedTable):
    """Stress or strain at nodes of a body's elements; of a shell at its bottom, middle and top."""

    kind: Literal["stress", "strain"]
    name: str = Field(description="its columns are NAME.von Mises, NAME.top xx, ...")
    at: str = Field(description="BODY.NODE_SET")
    component: _Component | None = Field(
        None, description="von-mises if left out; components are in the axes of the body"
    )
    measure: Literal["max", "mean", "nearest", _Component] = Field(
        "max",
        description="of the nodes of the set: largest magnitude, mean, or the node nearest the centroid",
    )

    def build(self, case: SensedCase) -> sensors.Sensor:
        """The sensor."""
        body, where = case.place(self.at)
        if body not in case.elements or isinstance(where, str):
            raise ModelError(f"sensor '{self.name}': '{self.at}' is no node set of a body with elements")
        made = sensors.StrainSensor if self.kind == "strain" else sensors.StressSensor
        measure = _tensor_measure(self._component)
        return made(self.name, body, case.elements[body], np.asarray(where), measure, self._over)

    @property
    def _component(self) -> str:
        """A component stood in `measure` before sets had one."""
        stated = None if self.measure in _OVER else self.measure
        return self.component or stated or "von-mises"

    @property
    def _over(self) -> sensors.OverNodes:
        return _OVER.get(self.measure, sensors.Maximum())


_OVER: Mapping[str, sensors.OverNodes] = {
    "max": sensors.Maximum(),
    "mean": sensors.Mean(),
    "nearest": sensors.Nearest(),
}


def _tensor_measure(component: str) -> sensors.TensorMeasure:
    own: Mapping[str, sensors.TensorMeasure] = {
        "von-mises": sensors.VonMises(),
        "principal": sensors.Principal(),
    }
    return own.get(component) or sensors.Component(component)


class SectionSensor(CheckedTable):
    """Force and moment across a section, of what lies beyond it on what lies before it."""

    kind: Literal["section-force"]
    name: str = Field(description="its columns are NAME.Fx, ..., NAME.Mz")
    at: str = Field(
        description="BODY.INTERFACE or BODY.NODE_SET: the place, or the mean, the section goes through"
    )
    normal: Vector = Field(description="across the section, towards what lies beyond, axes of the mesh")

    def build(self, case: SensedCase) -> sensors.Sensor:
        """The sensor."""
        at = _place(case, self.at)
        return sensors.SectionForceSensor(self.name, at, self.normal, case.elements.get(at.body))


class SpringSensor(CheckedTable):
    """What a spring and damper, or another element, carries, or has stored."""

    kind: Literal["spring-force", "element-energy"]
    name: str = Field(description="its columns are NAME.Fx, ..., NAME.Mz; or NAME.stored, NAME.power")
    spring: str = Field(description="name of a spring or an element")

    def build(self, case: SensedCase) -> sensors.Sensor:
        """The sensor."""
        if self.kind == "element-energy":
            return sensors.ElementEnergySensor(self.name, case.springs[self.spring])
        return sensors.SpringForceSensor(self.name, case.springs[self.spring])


class EnergyTable(CheckedTable):
    """Energies of the whole machine."""

    kind: Literal["energy"]
    name: str = Field(description="its columns are NAME.kinetic, NAME.strain, ...")

    def build(self, _: SensedCase) -> sensors.Sensor:
        """The sensor."""
        return sensors.EnergySensor(self.name)


SensorTable = Annotated[
    PlaceSensor | JointSensor | SectionSensor | SpringSensor | TensorSensor | EnergyTable,
    Field(discriminator="kind"),
]


def sensed_places(raw: Raw) -> Iterator[tuple[KeyPath, str, Any, bool]]:
    """Every place that a sensor names: table, key, what stands there, whether it may be a node set."""
    for path, each in tables(raw, "sensor"):
        yield path, "at", each.get("at"), True
        yield path, "seen_from", each.get("seen_from"), False


def _elements_exist(raw: Raw) -> Mistakes:
    for what in ("joint", "spring"):
        places = ("spring", "element") if what == "spring" else (what,)
        known = [str(each["name"]) for place in places for _, each in tables(raw, place) if "name" in each]
        for path, each in tables(raw, "sensor"):
            name = each.get(what)
            if isinstance(name, str) and name not in known:
                yield (*path, what), unknown(what, name, known)


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "sensor")
    for path, each in tables(raw, "sensor"):
        name = each.get("name")
        if isinstance(name, str) and not name.strip():
            yield (*path, "name"), "the name of a sensor is empty; give it one, for the heads of its columns"


def _sees_deflections(raw: Raw) -> Mistakes:
    for path, each in tables(raw, "sensor"):
        if each.get("seen_from") is not None and each.get("kind") != "deflection":
            yield (*path, "seen_from"), 'only a sensor of kind "deflection" is seen from an interface'


def _stress_is_of_elements(raw: Raw) -> Mistakes:
    """The rule that stress and strain are read at node sets of bodies with elements."""
    bodies = {str(body.get("name")): body for _, body in tables(raw, "body")}
    for path, each in tables(raw, "sensor"):
        name, _, where = str(each.get("at")).partition(".")
        if each.get("kind") not in ("stress", "strain") or name not in bodies:
            continue
        kind = kind_of(bodies[name])
        if kind is not None and not kind.has_elements:
            able = ", ".join(kinds_that("has_elements"))
            yield (*path, "at"), f"body {name!r} has no elements, whose stress it would be ({able} have)"
        elif where in names(bodies[name], "interface"):
            yield (
                (*path, "at"),
                f"{where!r} is an interface, and stress is that of elements: this is no node set of a body "
                "with elements; name one",
            )


def _one_component(raw: Raw) -> Mistakes:
    for path, each in tables(raw, "sensor"):
        stated = each.get("measure")
        if "component" in each and isinstance(stated, str) and stated not in _OVER:
            yield (
                (*path, "measure"),
                f"beside component, measure is one of {', '.join(_OVER)}; it says {stated!r}",
            )


RULES = (_elements_exist, _names_differ, _sees_deflections, _stress_is_of_elements, _one_component)

"""The sensors of a case."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from supple import quantities
from supple.cases.body_kinds import at_elements
from supple.cases.shared_rules import InterfaceOf, PlaceOf, joint_names, usable_names
from supple.cases.stated_error import OF_STRESS
from supple.cases.table import Key, Made, OneOf, table_of
from supple.errors import ModelError, SuppleWarning
from supple.fem import FiniteElementModel, model_of_cells, node_of_several_walls
from supple.importers.toml import Mistakes, Raw, tables, unknown
from supple.machine import At, ForceElement, as_end
from supple.storage.dataset_labels import name_taken_in_hdf5


class SensedCase(NamedTuple):
    """Parts of a case that sensors need."""

    place: Callable[[str], quantities.Place]
    """Function from `BODY.PLACE` to the place."""
    bases: Mapping[str, At]
    """Reference interfaces of deflections, by name of a part of a split body."""
    elements: Mapping[str, FiniteElementModel]
    springs: Mapping[str, ForceElement]
    """Springs and force elements that have a name, by name."""


class SensorTable(Made):
    """The keys common to all sensors."""

    name: str = Field(description="prefix of the column names: NAME.x, NAME.Fx, NAME.angle, ...")


_Component = Literal["von-mises", "principal", "xx", "yy", "zz", "yz", "xz", "xy"]


class _Deflection(SensorTable):
    """Deflection of a place."""

    kind: Literal["deflection"]
    at: PlaceOf = Field(description="BODY.INTERFACE, or the mean of BODY.NODE_SET")
    seen_from: InterfaceOf | None = Field(None, description="BODY.INTERFACE; default: the body's first one")

    def build(self, *context: Any) -> quantities.Quantity:
        """The sensor."""
        (case,) = context
        at = case.place(self.at)
        base = case.bases.get(at.body) if self.seen_from is None else as_end(self.seen_from)
        return quantities.DeflectionSensor(self.name, at, base)


class TensorSensor(SensorTable):
    """Stress or strain at nodes of a body's elements; of a shell at its bottom, middle and top."""

    kind: Literal["stress", "strain"] = Field(description="stress or strain")
    at: PlaceOf = Field(description="BODY.NODE_SET")
    component: _Component | None = Field(None, description="default von-mises; components are in body axes")
    measure: Literal["max", "mean", "nearest", _Component] = Field(
        "max",
        description="over the nodes of the set: largest magnitude, mean, or the node nearest the centroid",
    )
    cells: str | None = Field(
        None, description="cell set whose elements alone are averaged at a node; default: all at the node"
    )

    def build(self, *context: Any) -> quantities.Quantity:
        """The sensor."""
        (case,) = context
        body, nodes = case.place(self.at).body, case.place(self.at).at
        if body not in case.elements or isinstance(nodes, str):
            raise ModelError(
                f"sensor '{self.name}': '{self.at}' is no node set of a body with elements; give such a set"
            )
        made = quantities.StrainSensor if self.kind == "strain" else quantities.StressSensor
        # Older files have the component in `measure`.
        component = self.component or (self.measure if self.measure not in _OVER else "von-mises")
        measure = _MEASURES.get(component) or quantities.Component(component)
        over = _OVER.get(self.measure, quantities.Maximum())
        return made(self.name, body, self._elements(case.elements[body], nodes), nodes, measure, over)

    def _elements(self, model: FiniteElementModel, nodes: Sequence[int]) -> FiniteElementModel:
        """The elements whose stress is averaged at the nodes."""
        if self.cells is not None:
            return model_of_cells(model, self.cells)
        if (node := node_of_several_walls(model, np.asarray(nodes))) is not None:
            sets = ", ".join(f"'{name}'" for name in model.mesh.cell_sets)
            warnings.warn(
                f"sensor '{self.name}': at node {model.mesh.node_ids[node]} shells meet at an angle, and the "
                "mean of their stresses is the stress of none of them. Name the cell set of one wall, "
                f"cells = .. ({sets or 'the mesh has none'})",
                SuppleWarning,
                stacklevel=2,
            )
        return model


_OVER: Mapping[str, quantities.OverNodes] = {
    "max": quantities.Maximum(),
    "mean": quantities.Mean(),
    "nearest": quantities.Nearest(),
}
_MEASURES: Mapping[str, quantities.TensorMeasure] = {
    "von-mises": quantities.VonMises(),
    "principal": quantities.Principal(),
}


def _sensor(makes: type[quantities.Quantity], kind: str, **by_hand: Any) -> Any:
    return table_of(makes, kind, SensorTable, **by_hand)


_AT = {
    "place": Key(
        PlaceOf,
        "BODY.INTERFACE, or the mean of BODY.NODE_SET",
        "at",
        through=lambda at, case: case.place(at),
    )
}
_JOINT = {"joint": Key(description="name of the joint")}
_ELEMENT = {
    "element": Key(
        str, "name of a spring or an element", "spring", through=lambda name, case: case.springs[name]
    )
}
_ELEMENTS = Key(str, name="at", through=lambda at, case: case.elements.get(case.place(at).body))


def _model_of(body: str, case: SensedCase) -> FiniteElementModel:
    if body not in case.elements:
        raise ModelError(
            f"body '{body}' has no elements, so it has no beams (bodies with elements: "
            f"{', '.join(case.elements) or 'none'})"
        )
    return case.elements[body]


_BEAMS = {
    "body": Key(str, "name of the body"),
    "model": Key(str, name="body", through=_model_of),
    "end": Key(Literal[1, 2], "1: first node of the element, 2: second node", default=1),
}
Sensor = Annotated[
    SensorTable,
    OneOf(
        _sensor(quantities.PositionSensor, "position", **_AT),
        _sensor(quantities.VelocitySensor, "velocity", **_AT),
        _sensor(quantities.AccelerationSensor, "acceleration", **_AT),
        _sensor(quantities.AngularVelocitySensor, "angular-velocity", at=Key(InterfaceOf, "BODY.INTERFACE")),
        _Deflection,
        _sensor(quantities.JointMotionSensor, "joint-motion", **_JOINT),
        _sensor(quantities.JointForceSensor, "joint-force", **_JOINT),
        _sensor(quantities.SectionForceSensor, "section-force", **_AT, model=_ELEMENTS),
        _sensor(quantities.BeamForceSensor, "beam-force", **_BEAMS),
        _sensor(quantities.SpringForceSensor, "spring-force", **_ELEMENT),
        _sensor(quantities.ElementEnergySensor, "element-energy", **_ELEMENT),
        TensorSensor,
        _sensor(quantities.EnergySensor, "energy"),
    ),
]


def _elements_exist(raw: Raw) -> Mistakes:
    elements = (each for place in ("spring", "element") for _, each in tables(raw, place))
    springs = [str(each["name"]) for each in elements if "name" in each]
    for what, known in (("joint", joint_names(raw)), ("spring", springs)):
        for path, each in tables(raw, "sensor"):
            name = each.get(what)
            if isinstance(name, str) and name not in known:
                yield (*path, what), unknown(what, name, known)


def _names_differ(raw: Raw) -> Mistakes:
    yield from usable_names(raw, "sensor")
    named = {path: each["name"] for path, each in tables(raw, "sensor") if isinstance(each.get("name"), str)}
    for path, name in named.items():
        if not name.strip():
            yield (*path, "name"), "the name of a sensor is empty; give a name, the heading of its columns"
        elif reason := name_taken_in_hdf5(name, list(named.values())):
            yield (*path, "name"), reason


def _one_component(raw: Raw) -> Mistakes:
    for path, each in tables(raw, "sensor"):
        stated = each.get("measure")
        if "component" in each and isinstance(stated, str) and stated not in _OVER:
            yield (
                (*path, "measure"),
                f"with component, measure is one of {', '.join(_OVER)}; got {stated!r}",
            )


RULES = (
    _elements_exist,
    _names_differ,
    lambda raw: at_elements(raw, tables(raw, "sensor"), dict.fromkeys(("stress", "strain"), OF_STRESS)),
    _one_component,
)

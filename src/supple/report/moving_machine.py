"""A machine in the page: bodies, joints, force elements, loads and obstacles over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm, RigidBody
from supple.fem import FiniteElementModel, has_stress
from supple.integrate import FloatingMotion, Solution
from supple.machine import At, System
from supple.report.marked_place import Arrow, Link, arrows_of, joint_marks, links_of
from supple.report.moving_body import FIELD_TOLERANCE, MovingBody, moving_body, rigid_links
from supple.results.body_surface import Look
from supple.results.colouring import DEFLECTION, PLASTIC_STRAIN, Colouring, stress_colouring
from supple.results.obstacle_shape import obstacle_offsets, obstacle_shape
from supple.simulation.recorded_columns import check_motions
from supple.units import UNNAMED, UnitSystem

_SAMPLED = 60
"""Largest number of times at which the extent of the motion is evaluated."""
_LINK_THICKNESS = 0.012
"""Thickness of the bars of a rigid body, relative to the extent of the machine."""
_ARROW_LENGTH = 0.16
"""Length of the longest arrow, relative to the extent of the machine."""


@dataclass(frozen=True, eq=False)
class MovingObstacle:
    """A rigid obstacle: points (n, 3) and triangles (m, 3), moved by offsets (t, 3)."""

    points: FloatArray
    triangles: IntArray
    offsets: FloatArray


@dataclass(frozen=True)
class FieldScale:
    """Range of the values of a field over all bodies and times, for its colours, in the displayed unit.

    label : name of the field with its unit;   factor : displayed value over value in the model's units
    error : error stated beside the values in the page; zero if none is stated
    """

    label: str
    factor: float
    low: float
    high: float
    error: float = 0.0


@dataclass(frozen=True, eq=False)
class MovingMachine:
    """The drawn parts of a run.

    times : (t,);   scales : of the colour fields, by name, "deflection" among them
    low, high : (3,) corners of the extent over all times;   up : (3,) against gravity, or z
    arrow_length : length of the arrows of the largest force, moment and contact force
    """

    times: FloatArray
    bodies: Sequence[MovingBody]
    joints: Sequence[Link]
    links: Sequence[Link]
    arrows: Sequence[Arrow]
    obstacles: Sequence[MovingObstacle]
    scales: Mapping[str, FieldScale]
    low: FloatArray
    high: FloatArray
    up: FloatArray
    arrow_length: float


def moving_machine(
    system: System,
    solution: Solution,
    meshes: Mapping[str, Look] = MappingProxyType({}),
    *,
    elements: Mapping[str, FiniteElementModel] | None = None,
    bases: Mapping[str, At] = MappingProxyType({}),
    units: UnitSystem = UNNAMED,
) -> MovingMachine:
    """A machine in a run; parameters as for `write_report`.

    Raises ModelError for a solution with other basis columns than the bodies, and for meshes or elements of
    an unknown body.
    """
    check_motions(system, solution)
    for what, names in (("meshes", meshes), ("elements", elements or ())):
        for name in names:
            system.placed(name, what)  # a misspelt name is an error
    colourings = {} if elements is None else {"von Mises stress": stress_colouring(elements)}
    colourings["plastic strain"] = PLASTIC_STRAIN
    elastic = [
        moving_body(
            system,
            solution,
            placed.body,
            meshes.get(placed.body.name),
            colourings=_possible(placed.body, solution, colourings, elements or {}),
            bases=bases,
        )
        for placed in system.bodies
        if placed.body.n_coordinates or not placed.body.has_frame
    ]
    joints = list(joint_marks(system, solution))
    links, arrows = list(links_of(system, solution)), list(arrows_of(system, solution))
    rows = np.unique(np.linspace(0, len(solution.times) - 1, _SAMPLED).astype(int))
    rigid = system.bodies_of(RigidBody)
    places = [place for each in (*joints, *links) for place in (each.first, each.second)]
    seen = [body.positions(rows).reshape(-1, 3) for body in elastic]
    seen += [place.points[rows] for place in (*places, *(arrow.place for arrow in arrows))]
    seen += [body.positions(solution.bodies[name].at(rows)).reshape(-1, 3) for name, body in rigid.items()]
    seen += [solution.motion(name, FloatingMotion).position[rows] for name in rigid]
    points = np.concatenate(seen)
    extent = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    reached = np.concatenate([points, *_arrow_tails(arrows, _ARROW_LENGTH * extent, rows)])
    bodies = [
        *elastic,
        *(rigid_links(body, solution.bodies[name], _LINK_THICKNESS * extent) for name, body in rigid.items()),
    ]
    up = (
        -system.gravity / np.linalg.norm(system.gravity)
        if system.gravity.any()
        else np.array([0.0, 0.0, 1.0])
    )
    offsets = obstacle_offsets(system, solution)
    return MovingMachine(
        solution.times,
        bodies,
        joints,
        links,
        arrows,
        [
            MovingObstacle(*obstacle_shape(contact.obstacle, points), offsets[:, number])
            for number, contact in enumerate(system.rigid_contacts)
        ],
        _scales(elastic, colourings, units),
        reached.min(axis=0),
        reached.max(axis=0),
        up,
        _ARROW_LENGTH * extent,
    )


def _arrow_tails(arrows: Sequence[Arrow], length: float, rows: IntArray) -> Iterator[FloatArray]:
    """Tails (t, 3) of arrows with heads at their points; the largest of each kind has the full length."""
    largest: dict[str, float] = {}
    for arrow in arrows:
        size = float(np.linalg.norm(arrow.values, axis=1).max(initial=0.0))
        largest[arrow.kind] = max(size, largest.get(arrow.kind, 0.0))
    for arrow in arrows:
        yield arrow.place.points[rows] - length * arrow.values[rows] / (largest[arrow.kind] or 1.0)


def _possible(
    body: BodyForm,
    solution: Solution,
    colourings: Mapping[str, Colouring],
    elements: Mapping[str, FiniteElementModel],
) -> dict[str, Colouring]:
    """Colourings with values for a body: stress needs its elements, plastic strain explicit elements."""
    start = solution.bodies[body.name].at(slice(0, 1))
    return {
        name: each
        for name, each in colourings.items()
        if (each is PLASTIC_STRAIN or (body.name in elements and has_stress(elements[body.name])))
        and each.values(body, start, None) is not None
    }


def _scales(
    bodies: Sequence[MovingBody], colourings: Mapping[str, Colouring], units: UnitSystem
) -> dict[str, FieldScale]:
    """Scales of the available fields: stress first, then deflection, then plastic strain."""
    largest = {"deflection": [body.largest_displacement for body in bodies]}
    for name in colourings:
        largest[name] = [body.fields[name].largest for body in bodies if name in body.fields]
    scales = {}
    for name, colouring in {**colourings, "deflection": DEFLECTION}.items():
        if largest[name]:
            label, factor = colouring.label(units)
            high = factor * max(largest[name])
            error = 0.0 if name == "deflection" else FIELD_TOLERANCE * high
            scales[name] = FieldScale(label, factor, 0.0, high, error)
    return dict(sorted(scales.items(), key=lambda item: item[0] == "plastic strain"))

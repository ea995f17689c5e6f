"""A moving machine as data for the script of the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from supple.arrays import FloatArray
from supple.report.charts import Chart
from supple.report.marked_place import Link, MarkedPlace
from supple.report.moving_body import MovingBody
from supple.report.moving_machine import MovingMachine
from supple.report.nodal_shapes import NodalShapes
from supple.report.packed_arrays import PackedArrays, Packing

_LEVELS = 32767
_STEP = 1.5e-5
"""Rounding step of amplitudes times shapes, relative to the maximum of the field, if 16 bits suffice."""
_STEP_OF_FIELD = 3e-4
"""Rounding step of colour fields, relative to their maximum, if 16 bits suffice."""
_STILL = 1e-12
"""A mark counts as fixed to its body if it moves in the body's axes by at most this fraction of the machine's
extent. Its axes count as fixed if no component of their quaternion changes by more than this number."""


def scene_data(machine: MovingMachine, arrays: PackedArrays) -> dict[str, object]:
    """Add the arrays of a machine to `arrays`; return their layout and all texts.

    Positions in space are relative to the middle of the machine's bounding box; nodes and marks of a body are
    in the axes of this body.
    """
    middle = 0.5 * (machine.low + machine.high)
    numbers = {body.name: number for number, body in enumerate(machine.bodies)}
    marks = _Marks(machine, numbers, middle, arrays)
    return {
        "times": arrays.add(machine.times - machine.times[0], "f4"),
        "start": float(machine.times[0]),
        "middle": middle.tolist(),
        "half": (0.5 * (machine.high - machine.low)).tolist(),
        "up": machine.up.tolist(),
        "arrowLength": machine.arrow_length,
        "bodies": [_body_data(body, middle, arrays) for body in machine.bodies],
        "joints": [marks.of_ends(joint) for joint in machine.joints],
        "links": [marks.of_ends(link) for link in machine.links],
        "arrows": [
            {
                "name": arrow.name,
                "kind": arrow.kind,
                "place": marks.of(arrow.place),
                "largest": float(np.linalg.norm(arrow.values, axis=1).max(initial=0.0)),
                "values": arrays.add(arrow.values.T, "f4"),
            }
            for arrow in machine.arrows
        ],
        "obstacles": [
            {
                "points": arrays.add(each.points - middle, "f4"),
                "triangles": arrays.add(each.triangles.T, "i4"),
                "offsets": arrays.add(each.offsets.T, "f4"),
            }
            for each in machine.obstacles
        ],
        "scales": {name: vars(each) for name, each in machine.scales.items()},
    }


def chart_data(charts: Sequence[Chart], arrays: PackedArrays) -> list[dict[str, object]]:
    """Add the arrays of charts to `arrays`; return their layout and all texts.

    An abscissa that several charts share is added once.
    """
    known: dict[int, Packing] = {}
    found: list[dict[str, object]] = []
    for chart in charts:
        key = id(chart.abscissa)
        if key not in known:
            # Times long after zero differ by less than single precision resolves.
            known[key] = arrays.add(chart.abscissa, "f8")
        found.append(
            {
                "title": chart.title,
                "label": chart.label,
                "note": chart.note,
                "over": chart.abscissa_label,
                "abscissa": known[key],
                "names": list(chart.curves),
                "curves": arrays.add(np.stack(list(chart.curves.values())), "f4"),
            }
        )
    return found


def _body_data(body: MovingBody, middle: FloatArray, arrays: PackedArrays) -> dict[str, object]:
    surface, carriers = body.surface, body.surface.carriers
    carried = not np.array_equal(carriers, np.arange(len(carriers)))
    return {
        "name": body.name,
        "kind": body.kind,
        "seenFrom": body.seen_from,
        "nodes": arrays.add(body.rest, "f4"),
        "ids": arrays.add(body.node_ids, "i4"),
        "carriers": arrays.add(carriers, "i4") if carried else None,
        "unknown": arrays.add(body.unknown, "i4") if body.unknown.any() else None,
        "triangles": arrays.add(surface.triangles.T, "i4"),
        "edges": arrays.add(body.edges.T, "i4"),
        "lifetimes": None if surface.lifetimes is None else arrays.add(surface.lifetimes.T, "i4"),
        "pose": arrays.add(np.vstack([(body.position - middle).T, _quaternions(body.rotation).T]), "f4"),
        "displacement": None if body.displacement is None else _shapes_data(body.displacement, _STEP, arrays),
        "fields": {name: _shapes_data(each, _STEP_OF_FIELD, arrays) for name, each in body.fields.items()},
    }


def _shapes_data(field: NodalShapes, step: float, arrays: PackedArrays) -> dict[str, object]:
    """Shapes as integers, with more digits for larger contributions, and amplitudes scaled to match."""
    largest = np.abs(field.shapes).max(axis=(1, 2), initial=0.0)
    contribution = largest * np.abs(field.amplitudes).max(axis=0, initial=0.0)
    levels = np.clip(np.ceil(contribution / (step * (field.largest or 1.0))), 1, _LEVELS)
    unit = np.where(largest > 0, largest, 1.0) / levels
    whole = np.rint(field.shapes / unit[:, None, None]).transpose(0, 2, 1)
    return {
        "shapes": arrays.add(whole, "i2"),
        "amplitudes": arrays.add((field.amplitudes * unit).T, "f4"),
    }


class _Marks:
    """Positions of marks, each in the axes of its body."""

    def __init__(
        self, machine: MovingMachine, numbers: Mapping[str, int], middle: FloatArray, arrays: PackedArrays
    ) -> None:
        self._machine, self._numbers, self._middle, self._arrays = machine, numbers, middle, arrays
        self._still = _STILL * float(np.linalg.norm(machine.high - machine.low))

    def of_ends(self, link: Link) -> dict[str, object]:
        """Name, kind, and both ends."""
        ends = {"first": self.of(link.first), "second": self.of(link.second)}
        return {"name": link.name, "kind": link.kind, **ends}

    def of(self, place: MarkedPlace) -> dict[str, object]:
        """Body number (-1: the ground), rest position, and motion within the body; axes as quaternions."""
        number = self._numbers.get(place.body, -1)
        if number < 0:
            points, axes, rest = place.points - self._middle, place.axes, place.rest - self._middle
        else:
            body = self._machine.bodies[number]
            points, rest = body.local(place.points), place.rest
            axes = body.rotation.transpose(0, 2, 1) @ place.axes
        moved = points - rest
        if np.abs(moved).max(initial=0.0) <= self._still:
            moved = moved[:1]
        turned = _quaternions(axes)
        if np.abs(turned - turned[0]).max(initial=0.0) <= _STILL:
            turned = turned[:1]
        return {
            "body": number,
            "rest": rest.tolist(),
            "moved": self._arrays.add(moved.T, "f4"),
            "turned": self._arrays.add(turned.T, "f4"),
        }


def _quaternions(rotation: FloatArray) -> FloatArray:
    """Unit quaternions (t, 4), x y z w, of rotation matrices (t, 3, 3), with continuous sign."""
    found = Rotation.from_matrix(rotation).as_quat()
    turned = np.where(np.einsum("ti,ti->t", found[1:], found[:-1]) < 0, -1.0, 1.0)
    found[1:] *= np.cumprod(turned)[:, None]
    return found

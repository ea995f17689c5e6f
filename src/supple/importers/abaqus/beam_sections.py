"""Sections of beams: *BEAM SECTION by shape and material, *BEAM GENERAL SECTION by shape or by numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from supple.arrays import FloatArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.beam_shapes import beam_shape
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import ElementType
from supple.importers.abaqus.materials import DeckMaterial
from supple.importers.deck import BeamProperty, IsotropicMaterial
from supple.importers.keyword_file import fields, number_rows, numbers
from supple.importers.section_values import SectionValues
from supple.mesh import SectionGeometry

_OF_SECTIONS = ("CENTROID", "SHEARCENTER", "SECTIONPOINTS")


@dataclass(frozen=True, eq=False)
class SectionOfBeams:
    """A section of beams.

    n1 : (3,) vector in the plane of the beam axis and the first axis, in global axes
    shift : (y, z) position of the origin of `shape` from the node, m
    """

    material: IsotropicMaterial
    shape: SectionValues
    n1: FloatArray
    shift: tuple[float, float]

    def property_of(self, kind: ElementType) -> BeamProperty:
        """The property of elements of a type; Euler-Bernoulli elements (B33) are rigid in shear."""
        made = self.shape.beam_values(self.material.density)
        return BeamProperty(self.material, made if kind.shears else replace(made, K1=0.0, K2=0.0))

    def directions_and_offsets(
        self, ends: FloatArray, axis_nodes: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None]:
        """First axes (C, 3) of cells with ends (C, 2, 3), and offsets (C, 2, 3) of shear centres from nodes.

        The offsets are None if they are zero.

        axis_nodes : (C, 3) positions towards which the first axes point from the first end; None: use n1
        """
        along = ends[:, 1] - ends[:, 0]
        # A beam without length has a zero tangent; the mesh rejects it.
        tangent = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
        n1 = np.broadcast_to(self.n1, along.shape) if axis_nodes is None else axis_nodes - ends[:, 0]
        n1 = n1 - np.einsum("ci,ci->c", n1, tangent)[:, None] * tangent
        length = np.linalg.norm(n1, axis=1)
        # If n1 is parallel to the beam, the first axis is an arbitrary lateral direction.
        aside = np.eye(3)[np.argmin(np.abs(tangent), axis=1)]
        aside = aside - np.einsum("ci,ci->c", aside, tangent)[:, None] * tangent
        n1 = np.where((length > 1e-6 * np.linalg.norm(self.n1))[:, None], n1, aside)
        n1 = n1 / np.maximum(np.linalg.norm(n1, axis=1, keepdims=True), np.finfo(float).tiny)
        y, z = np.add(self.shape.centroid, self.shape.shear_centre) + self.shift
        if not y and not z:
            return n1, None
        offset = y * n1 + z * np.cross(tangent, n1)
        return n1, np.stack([offset, offset], axis=1)


def read_beam_section(
    model: AbaqusModel, placed: ScopedBlock, material: Callable[[str], DeckMaterial | None]
) -> SectionOfBeams | None:
    """A section of beams; None if its shape or material is not read.

    Raises
    ------
    ImportFormatError   no dimensions; E or G that is not positive; words instead of numbers
    """
    file, block = model.file, placed.block
    kind = block.options.get("SECTION", "GENERAL" if block.key == "BEAMGENERALSECTION" else "").upper()
    rows = [numbers(file, line, fields(text) if text else []) for line, text in block.placed_data]
    rows = rows[next((i for i, row in enumerate(rows) if row), 0) :]
    if not rows:
        raise file.error(block.line, f"*{block.name} without dimensions; is the file cut short?")
    made_of = material(block.options.get("MATERIAL", ""))
    by_numbers = block.key == "BEAMGENERALSECTION" and "MATERIAL" not in block.options
    if by_numbers:
        E, G = [*rows[-1], 0.0, 0.0][:2] if len(rows) > 1 else (0.0, 0.0)
        density = numbers(file, block.line, [block.options.get("DENSITY", "0")])[0]
        if not (E > 0 and G > 0):
            raise file.error(block.line, f"*{block.name}: its last line begins with E, G, both positive")
        nu = E / (2 * G) - 1
        made_of = IsotropicMaterial(E, nu, density) if nu < 0.5 else IsotropicMaterial(E, 0.3, density, G)
    shape = _by_numbers(rows[0]) if kind in ("", "GENERAL") else beam_shape(kind, rows[0])
    if shape is None or "TAPER" in block.options:
        model.report.leave_out(
            f"*{block.name}, SECTION={kind}", block.line, "beams of this section are missing"
        )
        return None
    if not isinstance(made_of, IsotropicMaterial):
        return None
    shape = _with_centres(model, placed, shape)
    has_axis = len(rows) > 2 or (len(rows) > 1 and not by_numbers)
    n1 = np.array([*rows[1], 0.0, 0.0, 0.0][:3]) if has_axis else np.array([0.0, 0.0, -1.0])
    if not np.linalg.norm(n1) > 0:
        n1 = np.array([0.0, 0.0, -1.0])
    # CalculiX: offset of the nodes from the axis as a fraction of the thickness.
    shares = numbers(file, block.line, [block.options.get(f"OFFSET{i}", "0") for i in (1, 2)])
    loops = () if shape.geometry is None else shape.geometry.loops
    size = np.ptp([place for loop in loops for place in loop], axis=0).tolist() if loops else (0.0, 0.0)
    shift = (-shares[0] * size[0], -shares[1] * size[1])
    return SectionOfBeams(made_of, shape, model.scopes[placed.scope].rotation @ n1, shift)


def _by_numbers(values: list[float]) -> SectionValues | None:
    """The shape with A, I11 = int z^2 dA, I12, I22 = int y^2 dA, J; None unless A, I11, I22, J > 0."""
    area, I11, I12, I22, J = [*values, *5 * [0.0]][:5]
    return SectionValues(area, I22, I11, I12, J, 1.0, 1.0) if min(area, I11, I22, J) > 0 else None


def _with_centres(model: AbaqusModel, placed: ScopedBlock, shape: SectionValues) -> SectionValues:
    """The shape with the *CENTROID, *SHEAR CENTER and *SECTION POINTS that follow its keyword."""
    start = next(i for i, each in enumerate(model.blocks) if each is placed)
    places: dict[str, list[float]] = {}
    for each in model.blocks[start + 1 : start + 4]:
        if each.block.key not in _OF_SECTIONS or not each.block.data:
            break
        places[each.block.key] = list(chain(*number_rows(model.file, each.block)))
        model.report.read[each.block.name] += 1
    if not places:
        return shape
    centroid, shear_centre = np.array(shape.centroid), np.add(shape.centroid, shape.shear_centre)
    geometry = shape.geometry and shape.geometry.moved(*shape.centroid)
    if "SECTIONPOINTS" in places:
        given = places["SECTIONPOINTS"]
        geometry = SectionGeometry(tuple(zip(given[::2], given[1::2], strict=False)))
    y, z = [*places.get("CENTROID", centroid), 0.0, 0.0][:2]
    shear_y, shear_z = [*places.get("SHEARCENTER", shear_centre), 0.0, 0.0][:2]
    return replace(
        shape,
        centroid=(y, z),
        shear_centre=(shear_y - y, shear_z - z),
        geometry=geometry and geometry.moved(-y, -z),
    )

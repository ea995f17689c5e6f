"""Sections of Abaqus and CalculiX: properties and cells of a Deck."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.beam_sections import SectionOfBeams, read_beam_section
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import CELL_FAMILIES, ElementBlock, Family, cells_of
from supple.importers.abaqus.materials import DeckMaterial, read_materials
from supple.importers.abaqus.orientation import Orientation, Orientations, orientation_of
from supple.importers.abaqus.public_names import public_name
from supple.importers.abaqus.walls import SectionOfShells, read_shell_section, thickness_of_sections
from supple.importers.deck import (
    AnisotropicMaterial,
    DeckElements,
    IsotropicMaterial,
    Property,
    RodProperty,
    SolidProperty,
)
from supple.importers.keyword_file import fields, numbers
from supple.mesh import CellType


@dataclass(frozen=True, eq=False)
class SectionOfSolids:
    """A section of solids or trusses; area : cross section of trusses, m^2."""

    material: DeckMaterial
    orientation: Orientation | None
    area: float


Section = SectionOfSolids | SectionOfShells | SectionOfBeams
_FITS = {
    Family.SOLID: SectionOfSolids,
    Family.ROD: SectionOfSolids,
    Family.SHELL: SectionOfShells,
    Family.MEMBRANE: SectionOfShells,
    Family.BEAM: SectionOfBeams,
}
_INCOMPATIBLE = ("C3D8I", "C3D8R", "SC8R")
"""Types that become cells with incompatible modes: C3D8I, and two with reduced integration in the file."""
_OF_WALLS = ("SHELLSECTION", "SHELLGENERALSECTION", "MEMBRANESECTION", "MEMBRANE")
_SECTIONS = ("SOLIDSECTION", *_OF_WALLS, "BEAMSECTION", "BEAMGENERALSECTION")


def read_elements(
    model: AbaqusModel, ids: IntArray, orientations: Orientations
) -> tuple[tuple[DeckElements, ...], dict[str, Property]]:
    """All elements with a section and a material, and their properties.

    Shells, beams and trusses without a section only define sets if all their nodes belong to solids with a
    section. All other elements whose section is missing or not read are listed in `left_out`. If sections
    overlap, the last one is used. ids : (E,) public ids of all elements

    Raises
    ------
    ImportFormatError   sections without thickness or dimensions; words instead of numbers
    """
    materials = read_materials(model)
    n_elements = len(model.element_labels.ids)
    section_of = np.full(n_elements, -1, dtype=np.int64)
    defined = {each.block.options.get("NAME", "") for each in model.blocks if each.block.key == "MATERIAL"}
    sections: list[tuple[str, Section | None]] = []
    unread: list[str] = []
    placed_sections = tuple(model.named(*_SECTIONS))
    walls = [each.block for each in placed_sections if each.block.key in _OF_WALLS]
    thicknesses = thickness_of_sections(model, walls)
    for placed in placed_sections:
        block = placed.block
        name = block.options.get("ELSET", "")
        members = model.elements_of(placed.scope, name, block.line, f"*{block.name}")
        section_of[members] = len(sections)
        key = public_name(model, placed.scope, name, model.element_sets)
        sections.append((key, _section(model, placed, materials, orientations, thicknesses)))
        material = block.options.get("MATERIAL", "")
        unread.append(_unread(material, materials, defined))
    unread.append("without a section")  # of elements with the number -1
    builder = _Builder(model, ids, read_releases(model))
    of_solids = np.zeros(len(model.positions), dtype=bool)
    for block in model.elements:
        if block.type.family is Family.SOLID:
            of_solids[block.nodes[section_of[block.numbers] >= 0]] = True
    for block in model.elements:
        if block.type.family not in CELL_FAMILIES:
            continue
        of_block = section_of[block.numbers]
        for number in np.unique(of_block).tolist():
            places = np.flatnonzero(of_block == number)
            key, section = sections[number] if number >= 0 else ("", None)
            if number < 0 and block.type.family is not Family.SOLID:
                # Meshers write the edges and faces of solids as well, for their sets.
                on_solids = of_solids[block.nodes[places]].all(axis=1)
                if on_solids.any():
                    count = int(np.count_nonzero(on_solids))
                    model.report.passed_over[f"*ELEMENT, TYPE={block.type.name}"] += count
                places = places[~on_solids]
                if not len(places):
                    continue
            if section is None or not isinstance(section, _FITS[block.type.family]):
                meaning = f"elements {unread[number]} are missing"
                model.report.leave_out_elements(block, places, meaning)
            else:
                builder.add(key, section, block, places)
        if _incompatible(block) and "R" in block.type.name:
            model.report.note(
                f"elements {block.type.name} are integrated fully, with incompatible modes for bending"
            )
    return tuple(builder.elements), builder.properties


def _unread(material: str, materials: Mapping[str, DeckMaterial], defined: Iterable[str]) -> str:
    """Words for `left_out` on elements whose section cannot be read: its material, if that is the cause."""
    if not material or material.upper() in materials:
        return "without a section that is read"
    known = material.upper() in {name.upper() for name in defined}
    cause = "has no elasticity that is read" if known else "is not defined"
    return f"of material '{material}', which {cause},"


def _section(
    model: AbaqusModel,
    placed: ScopedBlock,
    materials: Mapping[str, DeckMaterial],
    orientations: Orientations,
    thicknesses: Mapping[int, FloatArray],
) -> Section | None:
    block, scope = placed.block, placed.scope

    def material(name: str) -> DeckMaterial | None:
        return materials.get(name.upper())

    def orientation(name: str) -> Orientation | None:
        found = orientation_of(orientations, scope, name)
        if name and found is None:
            model.report.leave_out(
                f"*{block.name}, ORIENTATION={name}",
                block.line,
                "its orientation is not read; global axes are used",
            )
        return found

    if block.key.startswith("BEAM"):
        return read_beam_section(model, placed, material)
    if block.key != "SOLIDSECTION":
        return read_shell_section(model, placed, material, orientation, thicknesses.get(block.line))
    if "COMPOSITE" in block.options:
        model.report.leave_out_block(block, "solid elements of plies are missing")
        return None
    made_of = material(block.options.get("MATERIAL", ""))
    values = [value for line, text in block.data[:1] for value in numbers(model.file, line, fields(text))]
    area = values[0] if values and values[0] > 0 else 1.0
    axes = orientation(block.options.get("ORIENTATION", ""))
    return None if made_of is None else SectionOfSolids(made_of, axes, area)


class _Builder:
    """Elements and properties of a deck under construction."""

    def __init__(self, model: AbaqusModel, ids: IntArray, releases: BoolArray | None) -> None:
        self._model, self._ids, self._releases = model, ids, releases
        self.elements: list[DeckElements] = []
        self.properties: dict[str, Property] = {}

    def add(self, key: str, section: Section, block: ElementBlock, places: IntArray) -> None:
        """Add the cells of the elements with indices `places` in a block."""
        for kind, cells, owners in cells_of(block.type, block.nodes[places], self._model.positions):
            whole = (np.diff(np.sort(cells, axis=1), axis=1) != 0).all(axis=1)
            if not whole.all():
                meaning = "elements with repeated nodes that are no simpler cell are missing"
                self._model.report.leave_out_elements(block, places[owners[~whole]], meaning)
            if whole.any():
                self._add(key, section, block, kind, cells[whole], places[owners[whole]])

    def _add(
        self,
        key: str,
        section: Section,
        block: ElementBlock,
        kind: CellType,
        cells: IntArray,
        element: IntArray,
    ) -> None:
        positions = self._model.positions
        corners, numbers = positions[cells], block.first + element

        def append(
            name: str, made: Property, *, mine: IntArray | slice = slice(None), **of: FloatArray | None
        ) -> None:
            own = self._ids[numbers[mine]], self._model.file.numbers[block.lines[element[mine]]]
            self.elements.append(
                DeckElements(
                    *(block.type.name, kind, cells[mine], *own, self._key(name, made)),
                    released=released_ends(self._releases, numbers[mine]),
                    reduced=block.type.name.startswith("C3D20R"),
                    incompatible=_incompatible(block),
                    **of,
                )
            )

        match section:
            case SectionOfShells():
                for own, side in section.sides(corners, numbers):
                    for name, made, places in own.properties(key, cells[side], block.type):
                        mine = side[places]
                        along = None
                        if own.homogeneous is None:  # the stiffness depends on a direction
                            along = own.directions(corners[mine], numbers[mine])
                        append(name, made, mine=mine, directions=along)
            case SectionOfBeams():
                axis_nodes = None if block.axis_nodes is None else positions[block.axis_nodes[element]]
                along, offsets = section.directions_and_offsets(corners, axis_nodes)
                append(key, section.property_of(block.type), directions=along, offsets=offsets)
            case SectionOfSolids() if block.type.family is Family.ROD:
                made_of = section.material
                if isinstance(made_of, IsotropicMaterial):
                    append(key, RodProperty(made_of, section.area, 0.0, made_of.density * section.area))
                else:
                    meaning = "trusses of a material that is not isotropic are missing"
                    self._model.report.leave_out_elements(block, element, meaning)
            case SectionOfSolids():
                axes = None
                if section.orientation is not None and isinstance(section.material, AnisotropicMaterial):
                    axes = section.orientation.axes(corners.mean(axis=1), numbers)
                append(key, SolidProperty(section.material), directions=axes)

    def _key(self, key: str, made: Property) -> str:
        """The name of the set, with a number if the set has several properties."""
        name, n = key, 1
        while name in self.properties and not _same(self.properties[name], made):
            n += 1
            name = f"{key} {n}"
        self.properties[name] = made
        return name


def _incompatible(block: ElementBlock) -> bool:
    return block.type.name.rstrip("HT") in _INCOMPATIBLE


def _same(first: Property, second: Property) -> bool:
    return type(first) is type(second) and all(
        np.array_equal(getattr(first, each.name), getattr(second, each.name))
        for each in dataclass_fields(first)
    )


# --- released ends of beams

# Freedoms of rotations about the beam axis x (T) and the section axes y (M1) and z (M2).
_ROTATIONS = {"T": (3,), "M1": (4,), "M2": (5,), "ALLM": (3, 4, 5)}
_ENDS = {"S1": 0, "S2": 6}


def read_releases(model: AbaqusModel) -> BoolArray | None:
    """Released freedoms (E, 12) of the ends of all elements of a file; None without releases.

    A line names an element or set, then one or both ends (S1, S2), each with a code (M1, M2, T, M1-M2, ..,
    ALLM).
    """
    found = np.zeros((len(model.element_labels.ids), 12), dtype=bool)
    beams = np.zeros(len(found), dtype=bool)
    for block in model.elements:
        beams[block.numbers] = block.type.family is Family.BEAM
    for placed in model.named("RELEASE"):
        for line, text in placed.block.data:
            word, *rest = (each.upper() for each in fields(text) if each)
            members = model.elements_of(placed.scope, word, line, "*RELEASE")
            pairs = list(zip(rest[::2], rest[1::2], strict=False))
            known = all(
                end in _ENDS and all(part in _ROTATIONS for part in code.split("-")) for end, code in pairs
            )
            if not pairs or len(rest) % 2 or not known or not beams[members].all():
                meaning = "only releases of S1 or S2 by M1, M2, T or ALLM are read; other ends stay connected"
                model.report.leave_out("*RELEASE", line, meaning)
                continue
            for end, code in pairs:
                for freedom in (f for part in code.split("-") for f in _ROTATIONS[part]):
                    found[members, _ENDS[end] + freedom] = True
    return found if found.any() else None


def released_ends(releases: BoolArray | None, elements: IntArray) -> BoolArray | None:
    """Released freedoms (C, 12) of cells; None without releases.

    The first cell of a quadratic beam has the first end, the last cell the second.

    elements : (C,) number of the element of each cell; cells of one element are consecutive
    """
    if releases is None or not releases[elements].any():
        return None
    found = releases[elements].copy()
    inner = elements[1:] == elements[:-1]
    found[np.append(inner, False), 6:] = False
    found[np.append(False, inner), :6] = False
    return found

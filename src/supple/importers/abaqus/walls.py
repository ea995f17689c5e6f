"""Sections of shells and membranes: homogeneous, composite, offset, of nodal thickness, or by stiffness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import ElementType, Family
from supple.importers.abaqus.materials import DeckMaterial
from supple.importers.abaqus.orientation import Orientation
from supple.importers.deck import IsotropicMaterial, ShellProperty, WallProperty
from supple.importers.keyword_file import KeywordBlock, fields, number_rows, numbers
from supple.importers.laminate import Ply, laminate, orthotropic_ply

_FLAT, _ACROSS = [0, 1, 5], [4, 3]  # xx yy xy, and xz yz, of a solid's strains
_ALONG_NORMAL = np.cos(np.radians(0.1))


@dataclass(frozen=True, eq=False)
class SectionOfShells:
    """A section of shells or membranes.

    plies : from the bottom up; their thicknesses are scaled to the total thickness
    homogeneous : the isotropic material of the whole wall, or None
    given : the wall if the section gives its stiffness, or None
    offset : distance of the nodes from the middle along the normal, divided by the thickness
    nodal_thickness : (N,) thickness at the nodes, nan where `thickness` is used; None without it
    added_mass : non-structural, per area
    opposite : plies of walls whose normal is opposite to that of `orientation`, if these differ; else None
    """

    plies: tuple[Ply, ...]
    homogeneous: IsotropicMaterial | None
    given: WallProperty | None
    thickness: float
    offset: float
    orientation: Orientation | None
    nodal_thickness: FloatArray | None
    added_mass: float = 0.0
    opposite: tuple[Ply, ...] | None = None

    def sides(self, corners: FloatArray, elements: IntArray) -> Iterator[tuple[SectionOfShells, IntArray]]:
        """The section, and the indices of the cells with corners (C, 3, 3) that have it."""
        if self.opposite is None or self.orientation is None:
            yield self, np.arange(len(corners))
            return
        axes = self.orientation.axes(corners.mean(axis=1), elements)
        along = np.einsum("ci,ci->c", axes[:, :, (self.orientation.axis or 3) - 1], _normals(corners)) >= 0
        for section, mine in ((self, along), (replace(self, plies=self.opposite), ~along)):
            if mine.any():
                yield section, np.flatnonzero(mine)

    def properties(
        self, key: str, cells: IntArray, kind: ElementType
    ) -> Iterator[tuple[str, ShellProperty | WallProperty, IntArray]]:
        """Name, property and cell indices for each different mean nodal thickness of the cells (C, 3).

        kind : element type; membranes have no bending stiffness, and some shells are rigid in shear
        """
        if self.nodal_thickness is None:
            yield key, self._property(self.thickness, kind), np.arange(len(cells))
            return
        given = self.nodal_thickness
        found = np.where(np.isfinite(given), given, self.thickness)[cells].mean(axis=1)
        # Twelve digits, so that another order of summation gives the same property.
        values, which = np.unique(np.array([float(f"{t:.12g}") for t in found]), return_inverse=True)
        for i, thickness in enumerate(values.tolist()):
            name = key if len(values) == 1 else f"{key} t={thickness:.6g}"
            yield name, self._property(thickness, kind), np.flatnonzero(which == i)

    def directions(self, corners: FloatArray, elements: IntArray) -> FloatArray:
        """First directions (C, 3) of cells with corners (C, 3, 3) before projection; by default global x.

        Global z is used if the wall's normal is within 0.1 degrees of global x, as in both programs.
        """
        if self.orientation is not None:
            return self.orientation.shell_directions(corners.mean(axis=1), elements)
        normals = _normals(corners)
        along = np.abs(normals[:, 0]) >= _ALONG_NORMAL * np.linalg.norm(normals, axis=1)
        return np.where(along[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])

    def _property(self, thickness: float, kind: ElementType) -> ShellProperty | WallProperty:
        if self.given is not None:
            return self.given
        is_membrane = kind.family is Family.MEMBRANE
        if self.homogeneous is not None and not is_membrane:
            offset, factor = -self.offset * thickness, 5 / 6 if kind.shears else 0.0
            return ShellProperty(self.homogeneous, thickness, self.added_mass, offset, factor)
        scale = thickness / sum(ply.thickness for ply in self.plies)
        plies = [replace(ply, thickness=ply.thickness * scale) for ply in self.plies]
        bottom = -self.offset * thickness - thickness / 2
        wall = laminate(plies, bottom=bottom, added_mass=self.added_mass)
        if not is_membrane:
            return wall if kind.shears else replace(wall, shear=None)
        none = np.zeros((3, 3))
        return replace(wall, coupling=none, bending=none, shear=None, rotary_inertia_per_area=0.0)


def _normals(corners: FloatArray) -> FloatArray:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def read_shell_section(
    model: AbaqusModel,
    placed: ScopedBlock,
    material: Callable[[str], DeckMaterial | None],
    orientation: Callable[[str], Orientation | None],
    thicknesses: FloatArray | None,
) -> SectionOfShells | None:
    """A *SHELL SECTION, *SHELL GENERAL SECTION or *MEMBRANE SECTION; None if it has no supported material.

    thicknesses : (N,) thickness at the nodes, nan if not given; None if it does not apply

    Raises
    ------
    ImportFormatError   no thickness, or one that is not positive; too few stiffnesses; words instead of
                        numbers
    """
    file, block = model.file, placed.block
    axes = orientation(block.options.get("ORIENTATION", ""))
    density = numbers(file, block.line, [block.options.get("DENSITY", "0")])[0]
    offset = _offset(model, block)
    if not block.data:
        raise file.error(block.line, f"*{block.name} without a thickness; is the file cut short?")
    if "COMPOSITE" in block.options:
        plies = _plies(model, block, material, orientation, axes)
        if plies is None:
            return None
        found, axes, opposite = plies
        total = sum(ply.thickness for ply in found)
        by_nodes = thicknesses if "NODALTHICKNESS" in block.options else None
        return SectionOfShells(found, None, None, total, offset, axes, by_nodes, density, opposite)
    rows = number_rows(file, block)
    if block.key == "SHELLGENERALSECTION" and "MATERIAL" not in block.options:
        wall = _general(model, block, [value for row in rows for value in row], density)
        return SectionOfShells((), None, wall, wall.thickness, 0.0, axes, None)
    thickness = rows[0][0]
    made_of = material(block.options.get("MATERIAL", ""))
    if made_of is None:
        return None
    if not thickness > 0 and thicknesses is None and block.key != "MEMBRANE":
        raise file.error(
            block.line, f"*{block.name}: the thickness {thickness:g} is not positive; correct it"
        )
    if not thickness > 0 and thicknesses is None:
        model.report.note(f"*{block.name} without a thickness: its elements define sets only")
        return None
    homogeneous = made_of if isinstance(made_of, IsotropicMaterial) else None
    plies = (_ply(made_of, thickness if thickness > 0 else 1.0, 0.0),)
    return SectionOfShells(plies, homogeneous, None, thickness, offset, axes, thicknesses, density)


def _ply(material: DeckMaterial, thickness: float, angle: float) -> Ply:
    if isinstance(material, IsotropicMaterial):
        E, nu = material.youngs_modulus, material.poissons_ratio
        G = E / (2 * (1 + nu))
        return orthotropic_ply(E, E, nu, G, G, G, density=material.density, thickness=thickness, angle=angle)
    compliance = np.linalg.inv(material.elasticity)
    flat, across = (np.linalg.inv(compliance[np.ix_(some, some)]) for some in (_FLAT, _ACROSS))
    return Ply(np.asarray(flat, float), np.asarray(across, float), material.density, thickness, angle)


def _plies(
    model: AbaqusModel,
    block: KeywordBlock,
    material: Callable[[str], DeckMaterial | None],
    orientation: Callable[[str], Orientation | None],
    axes: Orientation | None,
) -> tuple[tuple[Ply, ...], Orientation | None, tuple[Ply, ...] | None] | None:
    """Plies, the axes from which their angles count, and `opposite`; None if a ply is not read.

    axes : those of the section, or None; then the axes of the first ply, if all plies name theirs
    """
    found: list[Ply] = []
    named: list[str] = []
    for line, text in block.data:
        words = [*fields(text), "", "", ""]
        thickness = numbers(model.file, line, words[:1])[0]
        if not thickness > 0:
            raise model.file.error(line, f"a ply of thickness {thickness:g}; correct it")
        made_of = material(words[2])
        if made_of is None:
            model.report.leave_out_block(block, f"the material '{words[2]}' of a ply is not read")
            return None
        is_name = words[3] and words[3].lstrip("+-")[:1] not in "0123456789."
        named.append(words[3] if is_name else "")
        angle = 0.0 if is_name else np.radians(numbers(model.file, line, words[3:4])[0])
        found.append(_ply(made_of, thickness, angle))
    own = {name: orientation(name) for name in named if name}
    if own and None not in own.values():
        if axes is None and not all(named):
            # An angle then counts from a global axis, whose direction in the wall differs by element.
            model.report.leave_out_block(block, "some plies have axes by name, and others have not")
            return None
        axes = axes or own[named[0]]
        for i, name in enumerate(named):
            angle = _angle_between(axes, own[name]) if name else found[i].angle
            if angle is None:
                model.report.leave_out_block(
                    block, "its plies have axes that are not rotated by one angle about one normal"
                )
                return None
            found[i] = replace(found[i], angle=angle)
    # An angle between named axes is about the normal of these, all others are about that of the wall.
    signs = [-1 if name else 1 for name in named]
    opposite = [replace(ply, angle=sign * ply.angle) for ply, sign in zip(found, signs, strict=True)]
    if "SYMMETRIC" in block.options:
        found, opposite = found + found[::-1], opposite + opposite[::-1]
    differs = any(name and ply.angle for ply, name in zip(found, named, strict=False))
    return tuple(found), axes, tuple(opposite) if differs else None


def _angle_between(first: Orientation | None, other: Orientation | None) -> float | None:
    """Angle from the first direction of `first` to that of `other` about their common normal.

    None without a common normal or one angle, tested at three points, or if either is distributed.
    """
    if first is other:
        return 0.0
    if first is None or other is None or first.distributed or other.distributed:
        return None
    places, nowhere = np.array([[1.0, 2.0, 3.0], [-5.0, 1.0, 2.0], [3.0, -7.0, -4.0]]), np.full(3, -1)
    a, b = first.axes(places, nowhere), other.axes(places, nowhere)
    axis = (first.axis or 3) - 1
    normal, x = a[:, :, axis], a[:, :, (axis + 1) % 3]
    if not np.allclose(normal, b[:, :, (other.axis or 3) - 1], atol=1e-6):
        return None
    other_x = other.shell_directions(places, nowhere)
    c, s = np.einsum("ni,ni->n", x, other_x), np.einsum("ni,ni->n", np.cross(x, other_x), normal)
    return float(np.arctan2(s[0], c[0])) if np.allclose((c, s), ([c[0]], [s[0]]), atol=1e-6) else None


def _general(
    model: AbaqusModel, block: KeywordBlock, values: list[float], mass_per_area: float
) -> WallProperty:
    """A wall by the 21 stiffnesses of its upper triangle, in the order 11, 12, 22, 13, 23, 33, 14 .."""
    if len(values) < 21:
        raise model.file.error(
            block.line,
            f"*SHELL GENERAL SECTION has 21 stiffnesses, not {len(values)}; is the file cut short?",
        )
    stiffness = np.zeros((6, 6))
    i, j = np.tril_indices(6)
    stiffness[i, j] = stiffness[j, i] = values[:21]
    A, B, D = stiffness[:3, :3], stiffness[:3, 3:], stiffness[3:, 3:]
    # D = A t^2 / 12 for a homogeneous wall.
    thickness = float(np.sqrt(12 * np.trace(D) / np.trace(A))) if np.trace(A) > 0 < np.trace(D) else 1.0
    return WallProperty(A, B, D, None, mass_per_area, 0.0, thickness)


def _offset(model: AbaqusModel, block: KeywordBlock) -> float:
    word = block.options.get("OFFSET", "").upper()
    if word in ("SPOS", "SNEG"):
        return 0.5 if word == "SPOS" else -0.5
    if word[:1].isalpha():
        model.report.leave_out(
            f"*{block.name}, OFFSET={word}", block.line, "the wall's middle is at its nodes"
        )
        return 0.0
    return numbers(model.file, block.line, [word])[0]


def thickness_of_sections(model: AbaqusModel, sections: Sequence[KeywordBlock]) -> dict[int, FloatArray]:
    """Thickness (N,) at the nodes for the sections to which *NODAL THICKNESS applies, by their lines.

    Abaqus requires NODAL THICKNESS on a section as well; CalculiX does not. If no section has it, it applies
    to all.
    """
    found = _nodal_thickness(model) if sections else None
    if found is None:
        return {}
    named = [block for block in sections if "NODALTHICKNESS" in block.options]
    if not named:
        model.report.note("*NODAL THICKNESS applies to all homogeneous walls, because no section names it")
    return {block.line: found for block in named or sections}


def _nodal_thickness(model: AbaqusModel) -> FloatArray | None:
    """Thickness at each node, nan if not given; None without *NODAL THICKNESS."""
    found = None
    for placed in model.named("NODALTHICKNESS"):
        if "GENERATE" in placed.block.options:
            model.report.leave_out_block(placed.block, "walls have the thickness of their section")
            continue
        if found is None:
            found = np.full(len(model.positions), np.nan)
        for line, text in placed.block.data:
            word, *rest = fields(text)
            value = numbers(model.file, line, rest[:1] or ["0"])[0]
            found[model.nodes_of(placed.scope, word, line, "*NODAL THICKNESS")] = value
    return found

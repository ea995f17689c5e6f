"""Sections of shells and membranes: homogeneous, composite, offset, of nodal thickness, or by stiffness."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from supple.importers.abaqus.assembly import ScopedBlock
from supple.importers.abaqus.deck_model import AbaqusModel
from supple.importers.abaqus.element_types import ElementType, Family
from supple.importers.abaqus.materials import DeckMaterial
from supple.importers.abaqus.orientation import Orientation
from supple.importers.deck import IsotropicMaterial, ShellProperty, WallProperty
from supple.importers.keyword_file import KeywordBlock, fields, numbers
from supple.importers.laminate import Ply, laminate, orthotropic_ply

__all__ = ["SectionOfShells", "read_shell_section"]

IntArray = NDArray[np.int64]
FloatArray = NDArray[np.float64]

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
    """

    plies: tuple[Ply, ...]
    homogeneous: IsotropicMaterial | None
    given: WallProperty | None
    thickness: float
    offset: float
    orientation: Orientation | None
    nodal_thickness: FloatArray | None

    @property
    def has_directions(self) -> bool:
        """Whether its stiffness depends on a direction in the wall."""
        return self.homogeneous is None

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
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = np.abs(normals[:, 0]) >= _ALONG_NORMAL * np.linalg.norm(normals, axis=1)
        return np.where(along[:, None], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])

    def _property(self, thickness: float, kind: ElementType) -> ShellProperty | WallProperty:
        if self.given is not None:
            return self.given
        is_membrane = kind.family is Family.MEMBRANE
        if self.homogeneous is not None and not is_membrane:
            offset, factor = -self.offset * thickness, 5 / 6 if kind.shears else 0.0
            return ShellProperty(self.homogeneous, thickness, offset=offset, shear_factor=factor)
        scale = thickness / sum(ply.thickness for ply in self.plies)
        plies = [replace(ply, thickness=ply.thickness * scale) for ply in self.plies]
        wall = laminate(plies, bottom=-self.offset * thickness - thickness / 2)
        if not is_membrane:
            return wall if kind.shears else replace(wall, shear=None)
        none = np.zeros((3, 3))
        return replace(wall, coupling=none, bending=none, shear=None, rotary_inertia_per_area=0.0)


def read_shell_section(
    model: AbaqusModel,
    placed: ScopedBlock,
    material: Callable[[str], DeckMaterial | None],
    orientation: Callable[[str], Orientation | None],
) -> SectionOfShells | None:
    """A *SHELL SECTION, *SHELL GENERAL SECTION or *MEMBRANE SECTION; None if it has no supported material.

    Raises
    ------
    ImportFormatError   no thickness, or one that is not positive; too few stiffnesses; words instead of
                        numbers
    """
    file, block = model.file, placed.block
    axes = orientation(block.options.get("ORIENTATION", ""))
    offset = _offset(model, block)
    # Abaqus requires NODAL THICKNESS on the section as well; CalculiX does not.
    thicknesses = _nodal_thickness(model)
    if not block.data:
        raise file.error(block.line, f"*{block.name} without a thickness; is the file cut short?")
    if "COMPOSITE" in block.options:
        plies = _plies(model, block, material, orientation)
        if plies is None:
            return None
        found, first = plies
        total = sum(ply.thickness for ply in found)
        return SectionOfShells(found, None, None, total, offset, axes or first, None)
    rows = [numbers(file, line, fields(text)) for line, text in block.data]
    if block.key == "SHELLGENERALSECTION" and "MATERIAL" not in block.options:
        wall = _general(model, block, [value for row in rows for value in row])
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
    return SectionOfShells(plies, homogeneous, None, thickness, offset, axes, thicknesses)


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
) -> tuple[tuple[Ply, ...], Orientation | None] | None:
    """Plies, and the orientation that the first ply with a name has (or None); None if a ply is not read."""
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
        angle = 0.0
        if words[3] and words[3].lstrip("+-")[:1] in "0123456789.":
            angle = np.radians(numbers(model.file, line, words[3:4])[0])
        elif words[3]:
            named.append(words[3].upper())
        found.append(_ply(made_of, thickness, angle))
    if not named:
        return tuple(found), None
    axes = [orientation(name) for name in named]
    if any(each is None for each in axes):
        return tuple(found), None
    first = axes[0]
    if len(set(named)) > 1:
        turns = iter(axes)
        rows = [(*fields(text), "", "", "")[3] for _, text in block.data]
        angles = [
            _angle_between(first, next(turns)) if row and row.upper() in named else None for row in rows
        ]
        if any(angle is None for angle in angles):
            model.report.leave_out_block(block, "plies along axes that are not rotated about one normal")
            return None
        found = [replace(ply, angle=angle or 0.0) for ply, angle in zip(found, angles, strict=True)]
    return tuple(found), first


def _angle_between(first: Orientation | None, other: Orientation | None) -> float | None:
    """Angle from the first direction of `first` to that of `other` about their common normal, at one point.

    None without a common normal, or if either is distributed.
    """
    if first is None or other is None or first.distributed or other.distributed:
        return None
    place, nowhere = np.array([[1.0, 2.0, 3.0]]), np.array([-1])
    a, b = first.axes(place, nowhere)[0], other.axes(place, nowhere)[0]
    normal = (first.axis or 3) - 1
    if not np.allclose(a[:, normal], b[:, (other.axis or 3) - 1], atol=1e-6):
        return None
    x, other_x = a[:, (normal + 1) % 3], other.shell_directions(place, nowhere)[0]
    return float(np.arctan2(np.cross(x, other_x) @ a[:, normal], x @ other_x))


def _general(model: AbaqusModel, block: KeywordBlock, values: list[float]) -> WallProperty:
    """A wall by the 21 stiffnesses of its upper triangle, in the order 11, 12, 22, 13, 23, 33, 14 .."""
    if len(values) < 21:
        raise model.file.error(
            block.line,
            f"*SHELL GENERAL SECTION has 21 stiffnesses, not {len(values)}; is the file cut short?",
        )
    stiffness = np.zeros((6, 6))
    rows = [row for column in range(6) for row in range(column + 1)]
    columns = [column for column in range(6) for _ in range(column + 1)]
    stiffness[rows, columns] = stiffness[columns, rows] = values[:21]
    A, B, D = stiffness[:3, :3], stiffness[:3, 3:], stiffness[3:, 3:]
    # D = A t^2 / 12 for a homogeneous wall.
    thickness = float(np.sqrt(12 * np.trace(D) / np.trace(A))) if np.trace(A) > 0 < np.trace(D) else 1.0
    density = numbers(model.file, block.line, [block.options.get("DENSITY", "0")])[0]
    return WallProperty(A, B, D, None, density, 0.0, thickness)


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


def _nodal_thickness(model: AbaqusModel) -> FloatArray | None:
    """Thickness at each node, nan if not given; None without *NODAL THICKNESS."""
    found = None
    for placed in model.blocks:
        if placed.block.key != "NODALTHICKNESS" or placed.step:
            continue
        model.report.read[placed.block.name] = 1
        if found is None:
            found = np.full(len(model.positions), np.nan)
        for line, text in placed.block.data:
            word, *rest = fields(text)
            value = numbers(model.file, line, rest[:1] or ["0"])[0]
            found[model.nodes_of(placed.scope, word, line, "*NODAL THICKNESS")] = value
    return found

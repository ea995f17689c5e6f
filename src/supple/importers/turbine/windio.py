"""windIO turbine files (.yaml): the outer shape of a blade, schema versions 1 and 2."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from supple.arrays import FloatArray
from supple.errors import ImportFormatError, MeshError, SuppleWarning
from supple.importers.turbine.windio_file import WindioFile
from supple.mesh import AirfoilSection, BladeStations
from supple.mesh.blade_stations import SHAPE_POINTS

__all__ = ["read_windio_blade"]


def read_windio_blade(path: str | Path) -> BladeStations:
    """Blade stations of a turbine file such as those of the IEA 3.4, 10, 15 and 22 MW reference turbines.

    The stations are all positions at which the file gives a chord or an airfoil. Between its airfoils, shapes
    are blended by monotone cubics (PCHIP): over the relative thickness if the file gives `rthick` along the
    span, else over the position. Prebend and sweep are those of the reference axis, in schema 2
    shifted by `section_offset_x` normal to the chord of the twisted section. Sections stay normal to z,
    whereas windIO rotates them with the axis.

    The span counts from the first point of the reference axis.

    Raises
    ------
    ImportFormatError   missing file, no YAML, missing entries, unknown airfoils, entries that are not numbers
    MeshError           airfoils or distributions that describe no blade
    Warns
    -----
    SuppleWarning       different airfoils at one position or of one `rthick`: the first is used
    Source: windIO turbine schema, versions 1 (`outer_shape_bem`) and 2 (`outer_shape`).
    """
    file = _OuterShape.read(path)
    blade = file.entry("components", "blade")
    second = isinstance(blade, dict) and "outer_shape" in blade
    shape = ("components", "blade", "outer_shape" if second else "outer_shape_bem")
    axis = ("components", "blade", "reference_axis") if second else (*shape, "reference_axis")

    names, places = file.airfoil_positions(shape, second)
    grid = np.union1d(file.numbers(*shape, "chord", "grid"), places)
    chord = file.covering(grid, *shape, "chord")(grid)
    twist = file.covering(grid, *shape, "twist")(grid)
    x, y, z = (file.covering(grid, *axis, name)(grid) for name in "xyz")
    twist = np.radians(twist) if second else twist
    if second:
        pitch_axis = file.covering(grid, *shape, "section_offset_y")(grid) / chord
        if file.has(*shape, "section_offset_x"):
            offset = file.covering(grid, *shape, "section_offset_x")(grid)
            x, y = x + offset * np.cos(twist), y - offset * np.sin(twist)
    else:
        pitch_axis = file.covering(grid, *shape, "pitch_axis")(grid)
    try:
        return BladeStations(
            span=z - z[0],
            sections=file.sections(shape, names, places, grid),
            chord=chord,
            twist=twist,
            pitch_axis=pitch_axis,
            prebend=x,
            sweep=y,
        )
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


class _OuterShape(WindioFile):
    """A windIO file with the entries of airfoils."""

    def airfoil_positions(self, shape: tuple[str, ...], second: bool) -> tuple[list[str], FloatArray]:
        """Names of the airfoils along the blade and their positions 0 .. 1."""
        if not second:
            labels = list(map(str, self.listed(*shape, "airfoil_position", "labels")))
            places = self.numbers(*shape, "airfoil_position", "grid")
            if len(labels) != places.size:
                raise ImportFormatError(
                    f"{self.path}: {'.'.join(shape)}.airfoil_position has {len(labels)} labels and "
                    f"{places.size} grid points; give as many of both"
                )
            return labels, places
        listed = [_OuterShape(self.path, airfoil) for airfoil in self.listed(*shape, "airfoils")]
        names = [str(airfoil.entry("name")) for airfoil in listed]
        places = [airfoil.entry("spanwise_position") for airfoil in listed]
        return names, self.as_numbers(places, ".".join((*shape, "airfoils", "spanwise_position")))

    def sections(
        self, shape: tuple[str, ...], names: list[str], places: FloatArray, grid: FloatArray
    ) -> tuple[AirfoilSection, ...]:
        """Sections at the positions `grid`, blended between the airfoils `names` at `places`."""
        known = [_OuterShape(self.path, airfoil) for airfoil in self.listed("airfoils")]
        airfoils = {str(airfoil.entry("name")): airfoil for airfoil in known}
        unknown = [name for name in names if name not in airfoils]
        if unknown:
            raise ImportFormatError(
                f"{self.path}: unknown airfoil '{unknown[0]}'; it has {', '.join(airfoils)}"
            )
        heights = np.array([airfoils[name].heights(name) for name in names])
        at = grid
        if self.has(*shape, "rthick"):
            places = np.array([airfoils[name].relative_thickness() for name in names])
            at = self.covering(grid, *shape, "rthick")(grid).clip(places.min(), places.max())
        places, first, which = np.unique(places, return_index=True, return_inverse=True)
        lost = np.flatnonzero(~np.isclose(heights, heights[first[which]]).all(axis=(1, 2)))
        if lost.size:
            kept = names[first[which[lost[0]]]]
            warnings.warn(
                f"{self.path}: airfoils '{kept}' and '{names[lost[0]]}' have the same position or relative "
                f"thickness, {places[which[lost[0]]]:g}: only '{kept}' is used there",
                SuppleWarning,
                stacklevel=3,
            )
        if places.size < 2:
            raise ImportFormatError(
                f"{self.path}: {'.'.join(shape)} needs airfoils at two or more positions; with rthick, "
                "airfoils of two or more relative thicknesses"
            )
        curve = self.blended(places, heights[first], "airfoils", extrapolate=True)
        blended = curve(at.clip(places[0], places[-1]))
        outlines = np.concatenate([blended[:, 0, ::-1], blended[:, 1, 1:]], axis=1)
        x = np.concatenate([SHAPE_POINTS[::-1], SHAPE_POINTS[1:]])
        return tuple(
            AirfoilSection(f"position {place:.4f}", np.column_stack([x, outline]))
            for place, outline in zip(grid, outlines, strict=True)
        )

    def heights(self, name: str) -> FloatArray:
        """Ordinates y/c (2, n) of the lower and upper side at `SHAPE_POINTS`, of the airfoil of this entry.

        name : name of the airfoil for messages
        """
        x, y = self.numbers("coordinates", "x"), self.numbers("coordinates", "y")
        if x.size != y.size:
            raise ImportFormatError(f"{self.path}: airfoil '{name}' has {x.size} x and {y.size} y")
        return AirfoilSection(name, np.column_stack([x, y])).heights(SHAPE_POINTS)

    def relative_thickness(self) -> float:
        """Nominal relative thickness of the airfoil; its key depends on the version of the schema."""
        key = "rthick" if "rthick" in self.tree else "relative_thickness"
        return float(self.as_numbers([self.entry(key)], key)[0])

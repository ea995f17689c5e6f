"""NREL 5 MW reference turbine: its 61.5 m blade and its rotor, from the tables shipped with supple."""

from __future__ import annotations

from importlib.resources import files

from supple.aero import Rotor
from supple.importers.turbine.station_table import read_rotor, read_stations
from supple.mesh import BladeGrid, BladeStations, ShearWebs

__all__ = ["NREL5MW_WEBS", "WU2019_GRID", "nrel5mw_rotor", "nrel5mw_stations"]

_FOLDER = files("supple") / "data" / "nrel5mw"

HUB_RADIUS = 1.5
"""Radius of the hub, m: a station at a span s has the radius s + HUB_RADIUS."""
HUB_HEIGHT = 90.0
"""Height of the hub above the ground, m."""

NREL5MW_WEBS = ShearWebs(start=1.3667, end=60.1333, fore=-0.3, aft=0.3)
"""Shear webs of the box spar of [Resor2013]; spar caps are 600 mm wide, centred on the pitch axis."""

WU2019_GRID = BladeGrid(centre_splits=((20, 3), (23, 3), (26, 3), (29, 3), (32, 3)))
"""3989 nodes and 8394 triangles, the size of the blade of [Wu2019].

A plain grid of 28 nodes around and 124 segments has 3984 and 8384; five quadrilaterals near the largest
chord, divided about their centres, add five nodes and ten triangles.
"""


def nrel5mw_stations() -> BladeStations:
    """The 38 stations of the 61.5 m blade. Source: [Resor2013], data file of NuMAD."""
    return read_stations(_FOLDER / "blade_stations.csv", sections=_FOLDER / "sections")


def nrel5mw_rotor() -> Rotor:
    """The three-bladed rotor of 126 m diameter, 19 stations. Source: [Jonkman2009], its AeroDyn files."""
    return read_rotor(_FOLDER / "rotor_stations.csv", polars=_FOLDER / "polars", n_blades=3)

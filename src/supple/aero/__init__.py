"""Aerodynamic loads prescribed in time: wind, polars, blade-element momentum, forces on nodes."""

from supple.aero.blade_element_momentum import AirLoads, Operation, air_loads, rotor_power, rotor_thrust
from supple.aero.polar import Polar
from supple.aero.prescribed_loads import CosineRamp, NodalForces, lumped_forces, prescribed_forces
from supple.aero.rotor import Rotor
from supple.aero.wind import (
    HarmonicSeries,
    PowerLawShear,
    Wind,
    golden_phases,
    kaimal_series,
    random_phases,
)

__all__ = [
    "AirLoads",
    "CosineRamp",
    "HarmonicSeries",
    "NodalForces",
    "Operation",
    "Polar",
    "PowerLawShear",
    "Rotor",
    "Wind",
    "air_loads",
    "golden_phases",
    "kaimal_series",
    "lumped_forces",
    "prescribed_forces",
    "random_phases",
    "rotor_power",
    "rotor_thrust",
]

"""Aerodynamic loads prescribed in time: wind, polars, blade-element momentum, forces on nodes."""

from supple.aero.blade_element_momentum import *
from supple.aero.polar import *
from supple.aero.prescribed_loads import *
from supple.aero.rotor import *
from supple.aero.wind import *

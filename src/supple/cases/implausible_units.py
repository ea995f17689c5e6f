"""Warnings of numbers of a case that are implausible in its units, or in any units.

A model in mixed units runs without an error. So every run checks densities, moduli, sizes, gravity, wave
speeds and first frequencies.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.body import FlexibleBody
from supple.body.model_check import USUAL_SPEEDS, WAVES_IN_STEEL, wave_speed
from supple.cases.case import Case
from supple.errors import UnitsWarning
from supple.fem import FiniteElementModel, Isotropic
from supple.methods.explicit import J2Plasticity
from supple.methods.explicit.element_part import ElementPart
from supple.reduction import ReducedBody
from supple.units import SI, UnitSystem


class _Range(NamedTuple):
    """Usual range of a quantity in SI units, an example, and the exponents of its base units."""

    lowest: float
    highest: float
    example: str
    powers: Mapping[str, int]


_DENSITY = _Range(1.0, 3e4, "steel has 7850 kg/m3", MappingProxyType({"mass": 1, "length": -3}))
_MODULUS = _Range(1e3, 2e12, "steel has 2.1e11 Pa", MappingProxyType({"mass": 1, "length": -1, "time": -2}))
_SIZE = _Range(1e-6, 3e3, "machines have millimetres to hundreds of metres", MappingProxyType({"length": 1}))
_GRAVITY = _Range(0.1, 1e3, "the earth has 9.81 m/s2", MappingProxyType({"length": 1, "time": -2}))
_FREQUENCY = _Range(0.05, 1e8, "the longest wind turbine blades have 0.5 Hz", MappingProxyType({"time": -1}))
# `wave_speed` returns some 2 to 6 times the speed of sound.
_SPEED = _Range(
    30.0, 2e5, "steel has some 2e4 m/s by this estimate", MappingProxyType({"length": 1, "time": -1})
)
# Lower limit of a metal's density, kg/m3, and upper limit of a rubber's modulus, Pa. No material has the
# density of a metal and the modulus of rubber, but a model with mixed kg, mm and MPa has.
_METAL, _RUBBER = 3e3, 2e9
_HARDEST = 0.1
"""Upper limit of the yield stress of a material, relative to Young's modulus."""
_REMEDY = "give the units of the numbers (units), and use one consistent set"


def warn_of_units(case: Case) -> None:
    """Warn, before a case is run, of numbers that are implausible in its units.

    Warns
    -----
    UnitsWarning    the number, its value in SI units, the usual value
    """
    units, gravity = case.units, float(np.linalg.norm(case.tables.gravity))
    doubts = list(_outside(units, "gravity", gravity, units.acceleration, _GRAVITY)) if gravity else []
    for name, body in case.flexible.items():
        doubts += [f"body '{name}': {doubt}" for doubt in _of_body(units, body)]
    if any(table.explicit is not None for table in case.parts.body):
        for name, part in case.system.bodies_of(ElementPart).items():
            doubts += [f"body '{name}': {doubt}" for doubt in _of_part(units, part)]
    _warn(doubts)


def warn_of_frequencies(units: UnitSystem, bodies: Iterable[ReducedBody]) -> None:
    """Issue UnitsWarning if the first frequency of a reduced body in its frame is implausible."""
    lowest = ((body.name, body.lowest_frequency() / (2 * np.pi)) for body in bodies)
    unit = "Hz" if units.time == SI.time else units.composed(time=-1)
    _warn(
        f"body '{name}': {doubt}"
        for name, frequency in lowest
        for doubt in _outside(units, "the first frequency", frequency, unit, _FREQUENCY)
    )


def _of_body(units: UnitSystem, body: FlexibleBody) -> list[str]:
    doubts = list(_of_shape(units, body.nodes, body.model))
    # A size or material out of range also changes the wave speed: one warning is enough.
    return doubts or list(_of_waves(units, body))


def _of_shape(
    units: UnitSystem, nodes: NDArray[np.float64], model: FiniteElementModel | None
) -> Iterator[str]:
    """Doubts of the size and the materials."""
    if len(nodes) > 1:  # a condensed model with one grid has no known size
        extent = float(np.ptp(nodes, axis=0).max())
        yield from _outside(units, "its size", extent, units.length, _SIZE)
    for material in _materials(model):
        yield from _of_material(units, material)


def _of_part(units: UnitSystem, part: ElementPart) -> Iterator[str]:
    """Doubts of explicit elements, also of a yield stress in another unit than the modulus."""
    yield from _of_shape(units, part.nodes, part.model)
    law = getattr(part, "law", None)
    if isinstance(law, J2Plasticity):
        stress, modulus = float(law.hardening.yield_stress(jnp.zeros(()))), law.elastic.youngs_modulus
        if stress > _HARDEST * modulus:
            unit = f" {units.stress}" if units.stress else ""
            yield (
                f"the yield stress is {stress:.3g}{unit}, and Young's modulus {modulus:.3g}{unit}; materials "
                f"yield below {_HARDEST:g} of their modulus"
            )


def _of_waves(units: UnitSystem, body: FlexibleBody) -> Iterator[str]:
    if body.model is None or not body.model.sections or len(body.nodes) < 2:
        return
    speed = wave_speed(body.nodes, body.model.stiffness, body.nodal_mass, dofs_per_node=body.dofs_per_node)
    if units.velocity:
        yield from _outside(units, "the speed of waves", speed, units.velocity, _SPEED)
    elif not USUAL_SPEEDS[0] <= speed <= USUAL_SPEEDS[1]:
        yield f"wave speed about {speed:.1e} per unit of time ({WAVES_IN_STEEL})"


def _materials(model: FiniteElementModel | None) -> list[Isotropic]:
    """The isotropic materials of elements, each once; a laminate has none."""
    properties = [section.property for section in model.sections] if model is not None else []
    found = [each if isinstance(each, Isotropic) else getattr(each, "material", None) for each in properties]
    return list(dict.fromkeys(each for each in found if each is not None))


def _of_material(units: UnitSystem, material: Isotropic) -> Iterator[str]:
    density, modulus = units.in_si(**_DENSITY.powers), units.in_si(**_MODULUS.powers)
    if material.density:
        yield from _outside(units, "the density", material.density, units.density, _DENSITY)
    yield from _outside(units, "Young's modulus", material.youngs_modulus, units.stress, _MODULUS)
    if density is None or modulus is None:
        return
    heavy, soft = density * material.density, modulus * material.youngs_modulus
    if _METAL < heavy <= _DENSITY.highest and _MODULUS.lowest <= soft < _RUBBER:
        yield f"its material is as heavy as a metal ({heavy:.3g} kg/m3) and as soft as rubber ({soft:.3g} Pa)"


def _outside(units: UnitSystem, what: str, value: float, unit: str, usual: _Range) -> Iterator[str]:
    factor = units.in_si(**usual.powers)
    if factor is not None and np.isfinite(value) and not usual.lowest <= factor * value <= usual.highest:
        si = "Pa" if usual is _MODULUS else "Hz" if usual is _FREQUENCY else SI.composed(**usual.powers)
        seen = f"{value:.3g} {unit}"
        in_si = "" if factor == 1.0 else f", which is {factor * value:.3g} {si}"
        yield f"{what} is {seen}{in_si}; {usual.example}"


def _warn(doubts: Iterable[str]) -> None:
    for doubt in doubts:
        warnings.warn(f"{doubt}: {_REMEDY}", UnitsWarning, stacklevel=3)

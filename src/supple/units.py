"""Unit system: the units of a model's numbers, and their names in pictures, tables and files.

A model is computed in any consistent set of units. The names of the units of length, mass and time define
the set; all other units follow from these. A unit that cannot be derived has no name, and is not written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isclose, pi, prod
from types import MappingProxyType
from typing import NamedTuple

from supple.errors import ModelError, did_you_mean

_INCH, _FOOT, _POUND, _POUND_FORCE = 0.0254, 0.3048, 0.45359237, 4.4482216152605

_LENGTHS = MappingProxyType(
    {"m": 1.0, "dm": 0.1, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "km": 1e3, "in": _INCH, "ft": _FOOT}
)
_MASSES = MappingProxyType(
    {
        "kg": 1.0,
        "g": 1e-3,
        "mg": 1e-6,
        "t": 1e3,
        "lb": _POUND,
        "slug": _POUND_FORCE / _FOOT,
        "slinch": _POUND_FORCE / _INCH,
        "lbf s2/in": _POUND_FORCE / _INCH,
        "lbf s2/ft": _POUND_FORCE / _FOOT,
    }
)
_TIMES = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0})
_FORCES = MappingProxyType(
    {
        "N": 1.0, "mN": 1e-3, "uN": 1e-6, "kN": 1e3, "MN": 1e6, "dyn": 1e-5,
        "lbf": _POUND_FORCE, "kip": 1e3 * _POUND_FORCE,
    }
)  # fmt: skip
_STRESSES = MappingProxyType(
    {
        "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "dyn/cm2": 0.1, "psi": _POUND_FORCE / _INCH**2,
        "ksi": 1e3 * _POUND_FORCE / _INCH**2, "lbf/ft2": _POUND_FORCE / _FOOT**2,
    }
)  # fmt: skip
_ENERGIES = MappingProxyType({"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3, "MJ": 1e6, "erg": 1e-7})
_WATTS = MappingProxyType({"W": 1.0, "mW": 1e-3, "uW": 1e-6, "kW": 1e3, "MW": 1e6})
_SPELLINGS = MappingProxyType({"µm": "um", "μm": "um", "µs": "us", "μs": "us", "sec": "s", "tonne": "t"})
_IMPERIAL = ("in", "ft")
# Units whose sizes in SI differ relatively by less than this are the same, within round-off.
_SAME = 1e-9


class DisplayUnit(NamedTuple):
    """A unit for display, and the factor from numbers in the model's units."""

    unit: str
    factor: float


def labelled(what: str, unit: str) -> str:
    """A label with its unit in brackets, or alone if the unit has no name."""
    return f"{what} ({unit})" if unit else what


def headed(what: str, unit: str) -> str:
    """The head of a column, "mass, kg", or "mass" if the unit has no name."""
    return f"{what}, {unit}" if unit else what


def with_unit(number: str, unit: str) -> str:
    """A number with its unit, or the number alone if the unit has no name."""
    return f"{number} {unit}" if unit else number


def plain_number(value: float, digits: int = 3) -> str:
    """A number with significant digits, such as "0.675".

    From 10^digits to 1e9 the number is rounded to a whole number: "1050", not "1.05e+03".
    """
    shown = f"{value:.{digits}g}"
    return f"{value:.0f}" if 10**digits <= abs(float(shown)) < 1e9 else shown


@dataclass(frozen=True)
class UnitSystem:
    """Names of the units of length, mass and time, each "" if unknown.

    The other units are derived from them: N from m, kg and s, MPa from mm, t and s. `UnitSystem()` has no
    names.

    Raises
    ------
    ModelError   an unknown unit
    """

    length: str = ""
    mass: str = ""
    time: str = ""

    def __post_init__(self) -> None:
        for name in _BASE:
            object.__setattr__(self, name, _known(name, getattr(self, name)))

    @classmethod
    def stated(cls, units: Mapping[str, str]) -> UnitSystem:
        """The system for given names of units of length, mass, time, force and stress.

        Without a unit of mass, this unit follows from length, time and force, or stress: slinch from in, s
        and lbf.

        Raises
        ------
        ModelError   an unknown quantity or unit; units that are not a consistent set, with the remedy; a
                     force or stress without length and time
        """
        for key in units:
            if key not in _STATED:
                raise ModelError(f"units cannot be given for {key!r}{did_you_mean(key, _STATED)}")
        given = {key: _known(key, unit) for key, unit in units.items()}
        length, time = given.get("length", ""), given.get("time", "")
        mass, derived = given.get("mass", ""), [key for key in ("force", "stress") if given.get(key)]
        for key in derived:
            if not (length and time):
                raise ModelError(
                    f"a unit of {key} needs units of length and time: give these, too, or leave out the {key}"
                )
            mass = mass or _mass_of(length, time, key, given[key])
        system = cls(length, mass, time)
        for key in derived:
            system._agrees(key, given[key])
        return system

    @classmethod
    def parsed(cls, text: str) -> UnitSystem:
        """The system from the text that `str` returns."""
        return cls(**dict(part.split(" ", 1) for part in text.split(", ") if part))

    def __str__(self) -> str:
        return ", ".join(f"{f.name} {getattr(self, f.name)}" for f in fields(self) if getattr(self, f.name))

    def in_si(self, *, mass: int = 0, length: int = 0, time: int = 0) -> float | None:
        """Size in SI of the unit with these powers; None if one of its units has no name."""
        powers = {"mass": mass, "length": length, "time": time}
        used = {name: power for name, power in powers.items() if power}
        if not all(getattr(self, name) for name in used):
            return None
        return prod(_BASE[name][getattr(self, name)] ** power for name, power in used.items())

    @property
    def velocity(self) -> str:
        """Length per time."""
        return self.composed(length=1, time=-1)

    @property
    def acceleration(self) -> str:
        """Length per time squared."""
        return self.composed(length=1, time=-2)

    @property
    def angular_velocity(self) -> str:
        """Radians per time."""
        return f"rad/{self.time}" if self.time else ""

    @property
    def force(self) -> str:
        """N, kN, lbf, .."""
        return self._named(_FORCES, mass=1, length=1, time=-2)

    @property
    def moment(self) -> str:
        """Force times length."""
        return self._per_force(" ", 1) or self.composed(mass=1, length=2, time=-2)

    @property
    def stress(self) -> str:
        """Unit of computed stresses and moduli; for display see `stress_shown`."""
        return self._named(_STRESSES, mass=1, length=-1, time=-2)

    @property
    def energy(self) -> str:
        """J, mJ, lbf in, .."""
        return self._named(_ENERGIES, mass=1, length=2, time=-2, otherwise=self.moment)

    @property
    def power(self) -> str:
        """W, mW, kW, .."""
        return self._named(_WATTS, mass=1, length=2, time=-3)

    @property
    def density(self) -> str:
        """Mass per length cubed."""
        return self.composed(mass=1, length=-3)

    @property
    def inertia(self) -> str:
        """Mass times length squared."""
        return self.composed(mass=1, length=2)

    @property
    def stress_shown(self) -> DisplayUnit:
        """Stresses are displayed in MPa, or in psi with lengths in feet or inches.

        If one of the units of length, mass and time is unknown, they are displayed unconverted.
        """
        factor = self.in_si(mass=1, length=-1, time=-2)
        if factor is None:
            return DisplayUnit("", 1.0)
        unit = "psi" if self.length in _IMPERIAL else "MPa"
        return DisplayUnit(unit, _ratio(factor, _STRESSES[unit]))

    @property
    def frequency_shown(self) -> DisplayUnit:
        """Frequencies are displayed in Hz for any known unit of time, else in cycles per unit of time."""
        factor = self.in_si(time=-1)
        return DisplayUnit("", 1.0) if factor is None else DisplayUnit("Hz", _ratio(factor, 1.0))

    @property
    def rotation_shown(self) -> DisplayUnit:
        """Rotation speeds are displayed in rpm for any known unit of time, else in rad per unit of time."""
        factor = self.in_si(time=-1)
        return (
            DisplayUnit("rad per unit of time", 1.0)
            if factor is None
            else DisplayUnit("rpm", _ratio(factor * 30, 1.0) / pi)
        )

    def _named(self, known: Mapping[str, float], *, otherwise: str = "", **powers: int) -> str:
        factor = self.in_si(**powers)
        if factor is None:
            return ""
        same = (name for name, size in known.items() if isclose(size, factor, rel_tol=_SAME))
        return next(same, otherwise or self.composed(**powers))

    def _per_force(self, sign: str, power: int) -> str:
        named = self.force in _FORCES
        return f"{self.force}{sign}{self.length}{power if power > 1 else ''}" if named else ""

    def composed(self, **powers: int) -> str:
        """Powers of length, mass and time, as "kg m2/s2"; "" if one of the units has no name."""
        names = {name: getattr(self, name) for name in powers}
        if not all(names.values()):
            return ""
        above = [_power(names[name], power) for name, power in powers.items() if power > 0]
        below = [_power(names[name], -power) for name, power in powers.items() if power < 0]
        under = f"({' '.join(below)})" if len(below) > 1 else "".join(below)
        return (" ".join(above) or "1") + (f"/{under}" if under else "")

    def _agrees(self, key: str, unit: str) -> None:
        powers = _POWERS[key]
        found = self.in_si(**powers)
        assert found is not None  # `stated` has length, mass and time
        if not isclose(_STATED[key][unit], found, rel_tol=1e-6):
            raise ModelError(
                f"the {key} in {unit} is not consistent with {self}, for which the unit of {key} is "
                f"{getattr(self, key)}. Give one consistent set, such as m, kg, s, N, Pa; mm, t, s, N, "
                "MPa; in, lbf s2/in, s, lbf, psi"
            )


_BASE = MappingProxyType({"length": _LENGTHS, "mass": _MASSES, "time": _TIMES})
_STATED = MappingProxyType({**_BASE, "force": _FORCES, "stress": _STRESSES})
_POWERS = MappingProxyType(
    {"force": {"mass": 1, "length": 1, "time": -2}, "stress": {"mass": 1, "length": -1, "time": -2}}
)


def _known(quantity: str, unit: str) -> str:
    """A unit in its usual spelling, or ""; `lbf*s^2/in`, `lbf·s²/in` and `lbf s2/in` are the same.

    Raises ModelError for an unknown unit.
    """
    plain = unit.strip().replace("²", "2").replace("^", "").replace("**", "")
    plain = " ".join(plain.replace("*", " ").replace("·", " ").split())
    given, known = _SPELLINGS.get(plain, plain), _STATED[quantity]
    if given and given not in known:
        raise ModelError(f"unknown unit of {quantity} {given!r}{did_you_mean(given, known)}")
    return given


def _mass_of(length: str, time: str, key: str, unit: str) -> str:
    """The mass consistent with length, time and a unit of force or stress.

    Raises ModelError if this mass has no name.
    """
    size = _STATED[key][unit] * _TIMES[time] ** 2 / _LENGTHS[length] ** _POWERS[key]["length"]
    same = [name for name, own in _MASSES.items() if isclose(own, size, rel_tol=_SAME)]
    if not same:
        raise ModelError(f"no known unit of mass matches {length}, {time} and {unit}: give the mass, too")
    return same[0]


def _power(name: str, power: int) -> str:
    plain = name if power == 1 else f"{name}{power}"
    return f"({name}){'' if power == 1 else power}" if "/" in name else plain


def _ratio(factor: float, unit: float) -> float:
    """The quotient rounded to 12 significant digits, so that a power of ten is exact."""
    quotient = factor / unit
    return float(f"{quotient:.12g}")


SI = UnitSystem("m", "kg", "s")
"""Metre, kilogram, second."""

UNNAMED = UnitSystem()
"""Unit system of a model whose units are not stated."""

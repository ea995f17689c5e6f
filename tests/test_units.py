"""Units follow from those of length, mass and time; what does not follow has no name."""

from __future__ import annotations

import pytest

from supple.errors import ModelError
from supple.units import SI, UNNAMED, UnitSystem, headed, labelled, plain_number, with_unit

DERIVED = ("force", "moment", "stress", "energy", "velocity", "density", "inertia")


@pytest.mark.parametrize(
    ("units", "names"),
    [
        (("m", "kg", "s"), ("N", "N m", "Pa", "J", "m/s", "kg/m3", "kg m2")),
        (("mm", "t", "s"), ("N", "N mm", "MPa", "mJ", "mm/s", "t/mm3", "t mm2")),
        (("mm", "kg", "ms"), ("kN", "kN mm", "GPa", "J", "mm/ms", "kg/mm3", "kg mm2")),
        (("cm", "g", "s"), ("dyn", "dyn cm", "dyn/cm2", "erg", "cm/s", "g/cm3", "g cm2")),
        (("ft", "slug", "s"), ("lbf", "lbf ft", "lbf/ft2", "lbf ft", "ft/s", "slug/ft3", "slug ft2")),
        (
            ("in", "lbf s2/in", "s"),
            ("lbf", "lbf in", "psi", "lbf in", "in/s", "(lbf s2/in)/in3", "(lbf s2/in) in2"),
        ),
        (("m", "lb", "s"), ("m lb/s2", "m2 lb/s2", "lb/(m s2)", "m2 lb/s2", "m/s", "lb/m3", "m2 lb")),
    ],
)
def test_derived_units_have_their_names(units, names):
    system = UnitSystem(*units)
    found = [getattr(system, name) for name in DERIVED]
    assert [sorted(one) for one in found] == [sorted(one) for one in names]
    assert UnitSystem.parsed(str(system)) == system


@pytest.mark.parametrize(
    ("units", "unit", "factor"),
    [
        (SI, "MPa", 1e-6),
        (UnitSystem("mm", "t", "s"), "MPa", 1.0),
        (UnitSystem("mm", "kg", "ms"), "MPa", 1e3),
        (UnitSystem("mm", "kg", "s"), "MPa", 1e-3),
        (UnitSystem("in", "slinch", "s"), "psi", 1.0),
        (UnitSystem("ft", "slug", "s"), "psi", 1 / 144),
        (UNNAMED, "", 1.0),
    ],
)
def test_stress_is_read_in_megapascals_or_psi(units, unit, factor):
    assert units.stress_shown.unit == unit
    assert units.stress_shown.factor == pytest.approx(factor, rel=1e-12)


def test_frequencies_are_read_in_hertz_whatever_time_is_in():
    assert UnitSystem(time="ms").frequency_shown == ("Hz", 1000.0)
    assert UNNAMED.frequency_shown == ("", 1.0)


def test_what_was_not_said_is_not_named():
    only_length = UnitSystem(length="mm")
    assert (only_length.force, only_length.stress, only_length.velocity, only_length.moment) == ("",) * 4
    assert labelled("deflection", only_length.length) == "deflection (mm)"
    assert labelled("force", only_length.force) == headed("force", "") == "force"
    assert (with_unit("3", ""), with_unit("3", "mm")) == ("3", "3 mm")


def test_the_mass_follows_from_the_force():
    inches = UnitSystem.stated({"length": "in", "force": "lbf", "time": "s"})
    assert inches == UnitSystem("in", "slinch", "s")
    assert inches.in_si(mass=1, length=-3) == pytest.approx(4.4482216152605 / 0.0254**4)
    assert UnitSystem.stated({"length": "mm", "stress": "MPa", "time": "s"}) == UnitSystem("mm", "t", "s")
    assert UnitSystem.stated({"mass": "lbf·s²/in"}) == UnitSystem(mass="lbf s2/in")


def test_a_number_is_plain_also_where_it_is_rounded_up():
    assert [plain_number(each) for each in (0.6749, 999.4, 999.7, 1050.0)] == ["0.675", "999", "1000", "1050"]


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            {"length": "mm", "mass": "kg", "time": "s", "stress": "MPa"},
            "the stress in MPa is not consistent with",
        ),
        ({"length": "mm", "mass": "kg", "time": "s", "force": "N"}, "the unit of force is .*, such as m"),
        ({"length": "metre"}, "unknown unit of length 'metre'"),
        ({"lenght": "m"}, "units cannot be given for 'lenght'.*did you mean 'length'"),
        ({"force": "newton"}, "unknown unit of force 'newton'"),
        ({"length": "ft", "time": "ms", "force": "dyn"}, "no known unit of mass matches ft, ms and dyn"),
        ({"length": "mm", "time": "s", "stress": "psi"}, "no known unit of mass matches mm, s and psi"),
        ({"length": "m", "force": "N"}, "a unit of force needs units of length and time: give these"),
    ],
)
def test_units_that_are_no_set_are_refused(stated, message):
    with pytest.raises(ModelError, match=message):
        UnitSystem.stated(stated)

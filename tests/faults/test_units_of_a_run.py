"""One machine in six systems of units: the same motion, and the same words up to the unit."""

from __future__ import annotations

import json
import re
import warnings
from itertools import pairwise

import h5py
import numpy as np
import pytest
from fixtures.systems_of_units import POWERS, SYSTEMS
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from supple.cases import read_case, run_case
from supple.errors import CaseError, UnitsWarning
from supple.results.run_tables import body_table, joint_table, motion_table, place_table
from supple.storage import read_solution
from supple.units import UnitSystem

STEPS = 12


@pytest.fixture(
    params=[("m-kg-s", "mm-t-s", "in-lbf-s"), tuple(SYSTEMS)],
    ids=["three", "all"],
)
def runs(machine, request):
    """The machine, run in several systems."""

    def run(name):
        path = machine(name, SYSTEMS[name], steps=STEPS)
        case = read_case(path)
        return case, run_case(case, path.parent / "out"), path.parent / "out" / "machine.h5"

    return {name: run(name) for name in request.param}


def in_si(units, quantity, values):
    return np.asarray(values) * units.in_si(**POWERS[quantity])


def close(found, expected, what):
    """Of a machine of some metres, a fraction of a second and radians."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=what)


def words(numbers):
    """Tables as rows of words, headings among them."""
    tables = [make(numbers) for make in (body_table, joint_table, motion_table, place_table)]
    return [cell for table in tables for row in (table.heads, *table.rows) for cell in row]


def without_units(cells, units):
    """Cells with the names of units taken out, numbers apart."""
    names = {getattr(units, what) for what in (*POWERS, "stress", "velocity")} | {"Hz"}
    pattern = "|".join(re.escape(name) for name in sorted(names - {""}, key=len, reverse=True))
    return [re.sub(rf"(?<=, )({pattern})$|(?<=\()({pattern})(?=\))", "UNIT", cell) for cell in cells]


def is_number(cell):
    return bool(re.fullmatch(r"[-+.e\d]+(  [-+.e\d]+)*", cell))


@pytest.mark.slow
def test_a_machine_does_not_know_its_units(runs):
    """Motion, forces and words of all runs agree once they are converted."""
    first, (case, result, _) = next(iter(runs.items()))
    reference, metre = result.solution, case.units
    said = without_units(words(result.numbers), metre)
    for name, (own, found, path) in runs.items():
        units, solution = own.units, found.solution
        close(in_si(units, "time", solution.times), reference.times, f"{name}: times")
        assert solution.statistics.steps == reference.statistics.steps
        assert solution.statistics.iterations == reference.statistics.iterations
        for body, motion in solution.bodies.items():
            close(in_si(units, "length", motion.position), reference.bodies[body].position, f"{name}: {body}")
            close(motion.rotation, reference.bodies[body].rotation, f"{name}: {body} turns")
        for place, tracked in found.tracked.items():
            expected = result.tracked[place]
            close(in_si(units, "length", tracked.position), expected.position, f"{name}: {place}")
            close(in_si(units, "length", tracked.deflection), expected.deflection, f"{name}: {place} bends")
        for joint, forces in solution.joint_forces.items():
            for part, what in ((slice(3), "force"), (slice(3, 6), "moment")):
                all_of = np.concatenate([own[:, part] for own in reference.joint_forces.values()])
                difference = in_si(units, what, forces[:, part]) - reference.joint_forces[joint][:, part]
                assert np.abs(difference).max() < 1e-7 * np.abs(all_of).max(), f"{name}: {joint} {what}"
        cells = without_units(words(found.numbers), units)
        assert [is_number(cell) for cell in cells] == [is_number(cell) for cell in said], name
        plain = [cell for cell in cells if not is_number(cell)]
        assert plain == [cell for cell in said if not is_number(cell)], name
        hertz = "frequencies in the frame, Hz"
        expected = result.numbers["bodies"]["arm"][hertz]
        np.testing.assert_allclose(found.numbers["bodies"]["arm"][hertz], expected, rtol=1e-8)
        with h5py.File(path) as file:
            hinge = file["joint_forces/pin"]
            assert hinge.attrs["acts_on"] == "bob.pin"
            assert list(hinge.attrs["unit"]) == [units.force] * 3 + [units.moment] * 3
            assert list(hinge.attrs["columns"])[:2] == ["force x", "force y"]
            assert hinge.attrs["axes"].startswith("joint axes that rotate with the first end")
            assert file["times"].attrs["unit"] == units.time
    assert first == "m-kg-s"
    assert all(one != other for one, other in pairwise(words(each[1].numbers) for each in runs.values()))


def texts_of_pictures(path, monkeypatch):
    """The words of every picture of a run, without the numbers on their axes."""
    seen = {}
    save = FigureCanvasAgg.print_png

    def hear(self, target):
        save(self, target)
        found = {text.get_text() for text in self.figure.findobj(Text)}
        seen[str(target)] = sorted(each for each in found if re.search("[A-Za-z]", each))

    with monkeypatch.context() as patched:
        patched.setattr(FigureCanvasAgg, "print_png", hear)
        case = read_case(path)
        result = run_case(case, path.parent / "out")
    return case, result, [line for lines in seen.values() for line in lines]


@pytest.mark.slow
def test_pictures_speak_the_units_of_the_case(machine, monkeypatch):
    """Stress of the same size in MPa, in SI and in mm; lengths in the unit said; none where none is said."""
    _, _, metre = texts_of_pictures(machine("m", SYSTEMS["m-kg-s"], steps=4, pictures=True), monkeypatch)
    _, _, milli = texts_of_pictures(machine("mm", SYSTEMS["mm-t-s"], steps=4, pictures=True), monkeypatch)
    _, _, plain = texts_of_pictures(machine("none", {}, steps=4, pictures=True), monkeypatch)
    stress = [
        next(float(found[1]) for line in lines if (found := re.match(r"largest (\S+), node", line)))
        for lines in (metre, milli)
    ]
    assert stress[0] == pytest.approx(stress[1], rel=1e-3)
    for lines, unit in ((metre, "m"), (milli, "mm")):
        assert {"von Mises stress (MPa)", f"deflection z ({unit})", f"x, global ({unit})"} <= set(lines)
        assert {
            f"moment, joint y (N {unit})",
            "force, joint z (N)",
            "time (s)",
            f"displacement ({unit})",
        } <= set(lines)
        assert any(re.fullmatch(rf"\d+(\.\d+)? {unit}", line) for line in lines)
    assert {
        "von Mises stress",
        "deflection z",
        "x, global",
        "force, joint z",
        "moment, joint y",
        "time",
    } <= set(plain)
    assert not [line for line in plain if re.search(r"\((m|mm|s|N|N m|MPa|Hz)\)|\d (m|s|Hz)\b", line)]


@pytest.mark.slow
def test_without_units_no_unit_is_written(machine):
    path = machine("none", {}, steps=4)
    result = run_case(read_case(path), path.parent / "out")
    report = json.loads((path.parent / "out" / "machine.json").read_text(encoding="utf-8"))
    assert report["units"] == {}
    assert "frequencies in the frame" in report["bodies"]["arm"]
    assert not [cell for cell in words(result.numbers) if re.search(r", (m|s|kg|N|N m|Hz)$", cell)]
    with h5py.File(path.parent / "out" / "machine.h5") as file:
        assert list(file["joint_forces/pin"].attrs["unit"]) == [""] * 6


def test_units_that_are_no_set_are_a_mistake_of_the_case_with_its_line(machine):
    path = machine("m", SYSTEMS["m-kg-s"])
    path.write_text(path.read_text(encoding="utf-8").replace('"kg"', '"t"'), encoding="utf-8")
    with pytest.raises(
        CaseError, match=r"line 3, units: the force in N is not consistent with length m, mass t"
    ):
        read_case(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("density = 2.7e-09", "density = 2700.0", "the density is 2.7e.03 t/mm3, which is 2.7e.15 kg/m3"),
        ("youngs_modulus = 70000.0", "youngs_modulus = 7e10", "Young's modulus is 7e.10 MPa, which is 7e.16"),
        ("-9810.0", "-9.81", "gravity is 9.81 mm/s2, which is 0.00981 m/s2"),
        ("thickness = 4.0", "thickness = 0.004", "the first frequency is 0.0[0-9]* Hz"),
    ],
)
def test_implausible_units_are_warned_of_in_a_run(machine, old, new, message):
    path = machine("mm", {"length": "mm", "mass": "t", "time": "s"}, steps=2)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    assert [each for each in doubts_of(path) if re.search(message, each)]


def test_a_material_as_heavy_as_a_metal_and_as_soft_as_rubber(machine):
    """Kilograms with mm and MPa: every number is usual by itself."""
    path = machine("mm", {"length": "mm", "mass": "kg", "time": "s"}, steps=2)
    text = path.read_text(encoding="utf-8")
    text = re.sub("density = .*", "density = 7.85e-6", text)
    path.write_text(re.sub("youngs_modulus = .*", "youngs_modulus = 2.1e5", text), encoding="utf-8")
    assert len(doubts_of(path)) == 1
    assert "as heavy as a metal (7.85e+03 kg/m3) and as soft as rubber (2.1e+08 Pa)" in doubts_of(path)[0]


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=() if each == "mm-t-s" else pytest.mark.slow) for each in SYSTEMS]
)
def test_usual_numbers_are_not_doubted(machine, name):
    assert doubts_of(machine(name, SYSTEMS[name], steps=2)) == []


def test_waves_without_units_are_as_fast_as_in_some_material(machine):
    """No unit is said, but no units make steel of these numbers."""
    path = machine("none", {}, steps=2)
    path.write_text(
        re.sub("density = .*", "density = 2.7e12", path.read_text(encoding="utf-8")), encoding="utf-8"
    )
    (doubt,) = doubts_of(path)
    assert "wave speed about" in doubt
    assert "in steel some 2e4 m/s" in doubt


def doubts_of(path):
    """What a run warns of before its first step."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", UnitsWarning)
        run_until_it_simulates(path)
    return [str(each.message) for each in heard if issubclass(each.category, UnitsWarning)]


def run_until_it_simulates(path):
    from supple.cases.implausible_units import warn_of_frequencies, warn_of_units
    from supple.simulation import reduced_bodies

    case = read_case(path)
    warn_of_units(case)
    warn_of_frequencies(case.units, reduced_bodies(case.system, case.flexible))


@pytest.mark.slow
def test_units_of_a_result_file_are_those_of_its_info(machine):
    from supple.results.descriptions import describe_result

    path = machine("mm", {"length": "mm", "mass": "kg", "time": "ms"}, steps=4)
    run_case(read_case(path), path.parent / "out")
    rows = dict(describe_result(path.parent / "out" / "machine.h5"))
    assert UnitSystem.parsed(rows["units"]) == UnitSystem("mm", "kg", "ms")
    assert rows["times"] == "3, from 0 to 20 ms"
    assert rows["joint pin"].startswith("force x, force y, force z, moment x")
    assert read_solution(path.parent / "out" / "machine.h5").joint_forces["pin"].shape == (3, 6)

"""Tables of a run's numbers."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.moving_machines import eroding

from supple.integrate import ErrorPart, ErrorStatement
from supple.machine import At, Contact, RigidPlane
from supple.methods.explicit import CONTACTS
from supple.quantities import ContactForceSensor, contact_names, read_sensors
from supple.results import summarize
from supple.results.run_tables import error_lines, error_table, motion_tables
from supple.units import UnitSystem


def test_each_row_of_the_error_table_has_the_unit_of_its_quantity():
    part = ErrorPart(2e-3, "a run with half the step")
    stated = {
        "arm": ErrorStatement("positions of body 'arm'", 0.5, step=part, quantity="length"),
        "root": ErrorStatement("stress at the root", 3.0, step=part, quantity="stress"),
        "bow": ErrorStatement("strain of the bow", 1e-3, step=part, quantity="strain"),
    }
    numbers = {
        "errors": {name: each.plain() for name, each in stated.items()},
        "units": {"length": "mm", "stress": "MPa"},
    }
    assert [row[0] for row in error_table(numbers).rows] == ["arm, mm", "root, MPa", "bow"]


def test_the_lines_below_the_error_table_name_what_it_does_not_contain():
    stated = ErrorStatement("positions of body 'arm'", 0.5, step=ErrorPart(2e-3, "half the step"))
    lines = error_lines({"errors": {"arm": stated.plain()}})
    assert lines[-1] == "The errors of mesh, material and loads are not included"
    assert error_lines({"errors": {}}) == []


def test_the_largest_force_of_each_contact_has_a_row():
    system, solution = eroding(np.ones((3, 4)))
    walls = [RigidPlane((9.0, 0, 0), (-1, 0, 0)), RigidPlane((0, 0, -9.0), (0, 0, 1))]
    hit = replace(system, contacts=[Contact(At("bar", "tip"), wall) for wall in walls])
    recorded = np.zeros((3, 12))
    recorded[1, :3], recorded[2, 6:9] = (-3.0, 4.0, 0.0), (0.0, 0.0, 7.0)
    run = replace(solution, series={CONTACTS: recorded})
    tables = motion_tables(summarize(hit, run, units=UnitSystem("mm", "t", "s")))
    assert [table.title for table in tables] == ["Bodies", "Contacts"]  # no table without rows
    assert tables[1].heads[1] == "largest force on the nodes, N"
    assert tables[1].rows == [["bar.tip", "5", "1", "-3  4  0"], ["bar.tip (2)", "7", "2", "0  0  7"]]
    (second,) = read_sensors([ContactForceSensor("wall", contact_names(hit)[1])], hit, run)
    assert second.values[:, 2] == pytest.approx([0, 0, 7.0])

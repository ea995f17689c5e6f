"""Tables of a run's numbers."""

from supple.integrate import ErrorPart, ErrorStatement
from supple.results.run_tables import error_lines, error_table


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

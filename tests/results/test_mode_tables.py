"""Tables of modes: what is printed of the numbers."""

from supple.linearization.linear_machine import STANDING
from supple.results.mode_tables import mode_tables


def test_round_off_of_damping_is_zero_and_without_a_basis_no_error_is_listed():
    mode = {
        "name": "a 1",
        "frequency": 4.0,
        "frequency in space": None,
        "whirl": "",
        "error": 0.0,
        "none of the machine's": False,
        "kinetic_share": {"a": 1.0},
        "unstable": False,
        "effective_mass": None,
    }
    modes = [{**mode, "damping_ratio": ratio} for ratio in (-1.97e-16, 8.2e-15, 0.0123, -2e-3)]
    numbers = {
        "units": {},
        "axes": STANDING,
        "periodic": False,
        "modes": modes,
        "mass": 1.0,
        "bodies with a basis": ["a"],
    }
    table = mode_tables(numbers)[0]
    column = table.heads.index("damping, %")
    assert [row[column] for row in table.rows] == ["0", "0", "1.23", "-0.2"]
    assert "error, %" in table.heads
    rigid = mode_tables({**numbers, "bodies with a basis": []})[0]  # no basis, no error: not unknown either
    assert "error, %" not in rigid.heads
    assert len(rigid.heads) == len(rigid.rows[0])

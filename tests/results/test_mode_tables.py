"""Tables of modes: what is printed of the numbers."""

from supple.linearization.linear_machine import STANDING
from supple.results.mode_tables import mode_table


def test_the_damping_of_an_undamped_machine_is_zero_without_round_off():
    mode = {
        "name": "a 1",
        "frequency": 4.0,
        "frequency in space": None,
        "whirl": "",
        "error": 0.0,
        "none of the machine's": False,
        "kinetic_share": {"a": 1.0},
        "unstable": False,
    }
    modes = [{**mode, "damping_ratio": ratio} for ratio in (-1.97e-16, 8.2e-15, 0.0123, -2e-3)]
    table = mode_table({"units": {}, "axes": STANDING, "periodic": False, "modes": modes})
    column = table.heads.index("damping, %")
    assert [row[column] for row in table.rows] == ["0", "0", "1.23", "-0.2"]

"""Tables of an equilibrium: one state, so that nothing is largest, last or at a time."""

import numpy as np

from supple.results.rest_tables import rest_tables


def test_a_state_is_listed_by_place_axis_and_value():
    numbers = {
        "units": {"length": "m", "force": "N", "moment": "N m"},
        "bodies": {"bar": {"kind": "rigid", "mass": 1.0}},
        "joints": {
            "hinge": {
                "acts on": "bar.root",
                "largest force": 5.0,
                "time of largest force": 0.0,
                "last force": np.array([3.0, 0.0, -4.0]),
                "largest moment": 1e-14,
                "time of largest moment": 0.0,
                "last moment": np.array([0.0, 1e-14, 0.0]),
            }
        },
        "tracked": {
            "bar.tip": {
                "seen from": "bar.root",
                "elastic": True,
                "last position": np.array([1.0, 0.0, -0.5]),
                "last deflection": np.array([0.0, 0.0, -0.25]),
            },
            "hub.axle": {"seen from": "", "elastic": False, "last position": np.array([0.0, 2.0, 0.0])},
            "hub.pin": {"seen from": "", "elastic": False, "last position": np.array([-2e-20, 0.0, 0.0])},
        },
    }
    _, joints, positions, deflections = rest_tables(numbers)
    assert joints.heads == ("joint", "acts on", "axis of the joint", "force, N", "moment, N m")
    assert [row[:4] for row in joints.rows] == [
        ["hinge", "bar.root", "x", "3"],
        ["", "", "y", "0"],
        ["", "", "z", "-4"],
    ]
    assert positions.heads == ("place", "global axis", "position, m")
    assert positions.rows[2:4] == [["", "z", "-0.5"], ["hub.axle", "x", "0"]]
    assert positions.rows[6] == ["hub.pin", "x", "0"]  # beside places of 2 m
    assert deflections.heads == ("place", "seen from", "axis", "deflection, m")
    assert deflections.rows == [["bar.tip", "bar.root", "x", "0"], ["", "", "y", "0"], ["", "", "z", "-0.25"]]
    words = " ".join(word for table in rest_tables(numbers) for word in (table.title, *table.heads))
    assert "largest" not in words
    assert "time" not in words


def test_errors_stand_beside_the_places_that_have_them():
    place = {"seen from": "root", "elastic": True, "last deflection": np.zeros(3)}
    tracked = {
        "bar.tip": place
        | {
            "last position": np.array([1.0, 0.0, 0.0]),
            "error of position": np.array([2e-3, -1e-15, 0.0]),
            "error of deflection": np.array([1.5e-3, 0.0, 0.0]),
        },
        "rod.end": place | {"last position": np.array([0.0, 1.0, 0.0])},
    }
    numbers = {"units": {"length": "m"}, "bodies": {}, "joints": {}, "tracked": tracked}
    _, positions, deflections = rest_tables(numbers)
    assert positions.heads[-1] == deflections.heads[-1] == "error of the basis, m"
    assert [row[-1] for row in positions.rows] == ["0.002", "0", "0", *["unknown"] * 3]
    assert deflections.rows[0] == ["bar.tip", "root", "x", "0", "0.0015"]


def test_what_is_not_there_has_no_table():
    tables = rest_tables({"units": {}, "bodies": {}, "joints": {}, "tracked": {}})
    assert [table.title for table in tables] == ["Bodies"]

"""Motions as data sets: named dimensions, and numbers as they are."""

import sys

import numpy as np
import pytest
from fixtures.made_up_solutions import make_solution

from supple.errors import MissingPackageError
from supple.methods.explicit import NodalMotion


def test_a_floating_motion_has_axes_and_coordinates():
    pytest.importorskip("xarray")
    solution = make_solution()
    motion = solution.bodies["beam/left 100%"]
    data = motion.to_xarray(solution.times)
    assert dict(data.sizes) == {"time": 7, "axis": 3, "body_axis": 3, "coordinate": 5}
    np.testing.assert_array_equal(data["rotation"].sel(time=0.2), motion.rotation[2])
    np.testing.assert_array_equal(data["coordinates"].isel(coordinate=4), motion.coordinates[:, 4])


def test_a_nodal_motion_has_nodes_and_elements():
    pytest.importorskip("xarray")
    places, values = np.zeros((2, 8, 3)), np.ones((2, 1))
    data = NodalMotion(places, places, places, values, values, values).to_xarray(np.array([0.0, 1.0]))
    assert dict(data.sizes) == {"time": 2, "node": 8, "axis": 3, "element": 1}


def test_without_the_package_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    solution = make_solution()
    with pytest.raises(MissingPackageError, match="xarray"):
        solution.bodies["hub"].to_xarray(solution.times)

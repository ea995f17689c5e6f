"""Sobol indices against the closed form of Ishigami's function."""

import numpy as np
import pytest

from supple.errors import ModelError
from supple.sweeps import Normal, SaltelliDesign, Uniform

ANGLE = Uniform(-np.pi, np.pi)
DESIGN = SaltelliDesign({"x": ANGLE, "y": ANGLE, "z": ANGLE}, 1024)


def columns(design):
    return [np.array(column) for column in design.table.columns.values()]


def test_ishigami():
    """a = 7, b = 0.1: published closed form (Ishigami and Homma 1990)."""
    x, y, z = columns(DESIGN)
    values = np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    found = DESIGN.indices(np.stack([values, 1e6 * values], axis=1))
    for output in (0, 1):  # units do not matter
        assert found.first[:, output] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.02)
        assert found.total[:, output] == pytest.approx([0.5576, 0.4424, 0.2437], abs=0.02)
    assert found.first.shape == (3, 2)
    assert found.total_interval.shape == (2, 3, 2)
    assert (found.total_interval[0] <= found.total).all()
    assert (found.total <= found.total_interval[1]).all()


def test_a_sum_of_normal_parameters_has_the_shares_of_their_variances():
    design = SaltelliDesign({"a": Normal(5.0, 1.0), "b": Normal(0.0, 2.0)}, 512)
    a, b = columns(design)
    assert a.mean() == pytest.approx(5.0, abs=0.02)
    found = design.indices(a + b)
    assert found.first == pytest.approx([0.2, 0.8], abs=0.02)
    assert found.total == pytest.approx([0.2, 0.8], abs=0.02)


def test_the_design():
    design = SaltelliDesign({"x": Uniform(0, 1), "y": Uniform(10, 20)}, 4)
    table = np.stack(columns(design), axis=1).reshape(4, 4, 2)
    a, b, with_x, with_y = table
    assert len(design.table) == design.n_cases == 16
    assert np.array_equal(with_x, np.stack([b[:, 0], a[:, 1]], axis=1))
    assert np.array_equal(with_y, np.stack([a[:, 0], b[:, 1]], axis=1))
    assert ((table[..., 1] > 10) & (table[..., 1] < 20)).all()


def test_what_has_no_indices_is_refused():
    with pytest.raises(ModelError, match="power of two"):
        SaltelliDesign({"x": ANGLE}, 100)
    with pytest.raises(ModelError, match="at least one"):
        SaltelliDesign({}, 4)
    design = SaltelliDesign({"x": ANGLE}, 4)
    values = np.arange(12.0)
    with pytest.raises(ModelError, match="12 cases"):
        design.indices(values[:-1])
    with pytest.raises(ModelError, match="1 cases have no finite"):
        design.indices(np.where(values == 3, np.nan, values))
    with pytest.raises(ModelError, match="same in all"):
        design.indices(np.ones(12))

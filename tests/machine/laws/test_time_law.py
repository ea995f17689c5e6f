"""What counts as a law of time, its ends, and what is refused."""

from __future__ import annotations

from itertools import count

import jax.numpy as jnp
import numpy as np
import pytest

from supple.errors import ModelError
from supple.machine import Constant, Scaled, Sine, SpinUp, Spline, Table, TimeFunction, Turning
from supple.machine.laws.time_law import as_time_law, check_law_shape


def test_only_tables_end():
    table = Table([0.5, 2.0], [1.0, 1.0])
    assert (table.begin, table.end) == (0.5, 2.0)
    assert Constant(3.0).begin == TimeFunction(jnp.sin).begin == float("-inf")
    assert Constant(3.0).end == TimeFunction(jnp.sin).end == float("inf")


def test_law_of_a_law_a_function_and_a_number():
    table = Table([0.0, 1.0], [0.0, 1.0])
    assert as_time_law(table) is table
    assert float(as_time_law(lambda t: 2 * t)(3.0)) == 6.0
    assert float(as_time_law(2.5)(7.0)) == 2.5
    np.testing.assert_array_equal(as_time_law([1.0, 2.0, 3.0])(0.0), [1.0, 2.0, 3.0])


def test_constant_with_nan():
    with pytest.raises(ValueError, match="a constant quantity has NaN or infinite entries"):
        as_time_law([0.0, float("inf"), 0.0])


def test_compound_laws_are_defined_where_all_their_parts_are():
    table = Table([0.5, 2.0], [1.0, 1.0])
    assert (Scaled([1.0, 0.0, 0.0], table).begin, Scaled([1.0, 0.0, 0.0], table).end) == (0.5, 2.0)
    vectors = Table([0.0, 1.5], np.zeros((2, 3)))
    turning = Turning(vectors, (0.0, 0.0, 1.0), table)
    assert (turning.begin, turning.end) == (0.5, 1.5)


def test_a_spline_ends_with_its_rows():
    """Held at its last value, it would stop a machine at once."""
    spline = Spline([0.5, 2.0], [1.0, 3.0])
    assert (spline.begin, spline.end) == (0.5, 2.0)


def test_a_law_of_ones_own_is_taken_as_it_stands():
    class Square:
        begin, end = 0.0, 1.0

        def __call__(self, time):
            return time**2

    law = Square()
    found = as_time_law(law)
    assert (found(0.5), found.begin, found.end) == (0.25, 0.0, 1.0)


def test_laws_are_not_wrapped_as_functions():
    """A function is part of the program; the numbers of a law must stay data."""
    for law in (Sine(1.0, 2.0), SpinUp(3.0), Spline([0.0, 1.0], [0.0, 1.0]), Scaled([1.0], 2.0)):
        assert as_time_law(law) is law


def test_values_of_the_wrong_shape_are_refused():
    with pytest.raises(ModelError, match=r"a load: its values over time have shape \(\); they must have"):
        check_law_shape("a load", Sine(1.0, 2.0), (3,))


def test_functions_of_numpy_are_refused():
    with pytest.raises(ModelError, match=r"a load: its function of time must be written with jax\.numpy"):
        check_law_shape("a load", TimeFunction(np.sin), ())


def test_laws_that_differ_in_numbers_alone_are_traced_once():
    calls = count()

    def pulse(time):
        next(calls)
        return jnp.sin(time)

    for amplitude in (1.0, 2.0, 3.0):
        check_law_shape("a load", Scaled([amplitude, 0.0, 0.0], TimeFunction(pulse)), (3,))
    assert next(calls) == 2  # of the factor, and of the whole
    with pytest.raises(ModelError, match=r"have shape \(3,\); they must have \(\)"):
        check_law_shape("a joint", Scaled([1.0, 0.0, 0.0], TimeFunction(pulse)), ())
    with pytest.raises(ModelError, match=r"have shape \(2,\); they must have \(3,\)"):
        check_law_shape("a load", Scaled([1.0, 0.0], TimeFunction(pulse)), (3,))


def test_laws_of_no_registered_class_are_traced_each():
    class Rows:
        begin, end = 0.0, 1.0

        def __init__(self, number):
            self.number = number

        def __call__(self, time):
            return time * jnp.ones(self.number)

    check_law_shape("a load", Rows(3), (3,))
    with pytest.raises(ModelError, match=r"have shape \(2,\)"):
        check_law_shape("a load", Rows(2), (3,))

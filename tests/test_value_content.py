"""The content of a value tells apart what gives other results, and nothing else."""

from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.value_content import UserFunction, content_of

RATE, TABLE, POINT = 2.0, {"a": 1.0}, SimpleNamespace(height=1.0)


def content(value):
    return list(content_of(value))


def of_globals(t):
    return jnp.sin(RATE * t) + TABLE["a"] + POINT.height


def within(t):
    return sum(rate * t for rate in (RATE, 1.0))


def calls(t):
    return of_globals(t)


@dataclass(frozen=True)
class Hat:
    height: float

    def __call__(self, t):
        return self.height * t


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (lambda t: 2 * jnp.sin(t), lambda t: 2 * jnp.cos(t)),
        (lambda t: t.real, lambda t: t.imag),
        (lambda t: 2 * t, lambda t: 3 * t),
        (lambda t, k=1: k * t, lambda t, k=2: k * t),
        (partial(pow, 2), partial(pow, 3)),
        (jax.jit(lambda t: 2 * jnp.sin(t)), jax.jit(lambda t: 2 * jnp.cos(t))),
        (jax.vmap(lambda t: 2 * jnp.sin(t)), jax.vmap(lambda t: 2 * jnp.cos(t))),
        (jnp.sin, jnp.cos),
        (np.sin, np.cos),
        (Hat(1.0), Hat(2.0)),
        (Hat(1.0).__call__, Hat(2.0).__call__),
        (lambda t: t in {1, 2}, lambda t: t in {1, 3}),
    ],
)
def test_functions_that_compute_something_else_have_other_contents(one, other):
    assert content(one) == content(one)
    assert content(one)[1:] != content(other)[1:]


@pytest.mark.parametrize("function", [of_globals, within, calls])
def test_a_number_that_a_function_reads_from_its_module_is_part_of_it(function, monkeypatch):
    before = content(function), UserFunction(function)
    assert before == (content(function), UserFunction(function))
    monkeypatch.setitem(globals(), "RATE", 3.0)
    assert content(function) != before[0]
    assert UserFunction(function) != before[1]


def test_so_are_an_entry_of_a_mapping_and_an_attribute(monkeypatch):
    before = content(calls)
    monkeypatch.setitem(TABLE, "a", 2.0)
    second = content(calls)
    monkeypatch.setattr(POINT, "height", 2.0)
    assert len({tuple(each) for each in (before, second, content(calls))}) == 3


def test_numbers_of_a_closure_are_part_of_it():
    def made(rate):
        return lambda t: rate * t

    assert content(made(1.0)) == content(made(1.0)) != content(made(2.0))
    assert content(made(jnp.ones(2))) != content(made(jnp.zeros(2)))


def test_a_function_that_calls_itself_and_a_mapping_that_contains_itself_have_contents():
    def itself(t):
        return itself(t - 1) if t > 0 else 0.0

    mapping = {"a": 1.0}
    mapping["itself"] = mapping
    assert content(itself)
    assert content(mapping)

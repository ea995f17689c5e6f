"""The content of a value tells apart what gives other results, and nothing else."""

import importlib
import sys
from argparse import Namespace
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from types import ModuleType, SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

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


class Settings:
    gain = 1.0


class Base:
    def torque(self, t):
        return RATE * t


class Motor(Base):
    """Its call uses a method, which reads a number from the module."""

    __slots__ = ("gain", "inner")

    def __init__(self, gain=1.0, inner=None):
        self.gain, self.inner = gain, inner

    def __call__(self, t):
        return self.gain * self.torque(t)

    def of_settings(self, t):
        return Settings.gain * self.inner(t)


MODULE = ModuleType("a_module_of_a_user")
MODULE.gain, MODULE.unused = 1.0, 1.0
MOTOR, OPTIONS = Motor(), Namespace(gain=1.0)
NAMES, RECORD = np.array(["a", "b"]), np.zeros(1, dtype=[("gain", float)])
HELD = [Fraction(1, 2), CubicSpline([0, 1, 2], [0, 1, 4])]


def of_module(t):
    return MODULE.gain * t


def of_class(t):
    return Settings.gain * t


def of_method(t):
    return MOTOR.torque(t)


def of_options(t):
    return OPTIONS.gain * t


def of_arrays(t):
    return t if NAMES[0] == "a" else RECORD["gain"][0] * t


def of_held(t):
    return HELD[0] * HELD[1](t)


@pytest.mark.parametrize(
    ("function", "change"),
    [
        (of_module, lambda change: change.setattr(MODULE, "gain", 2.0)),
        (of_class, lambda change: change.setattr(Settings, "gain", 2.0)),
        (of_method, lambda change: change.setitem(globals(), "RATE", 3.0)),
        (of_method, lambda change: change.setattr(Base, "torque", lambda self, t: 2 * t)),
        (MOTOR, lambda change: change.setitem(globals(), "RATE", 3.0)),
        (MOTOR, lambda change: change.setattr(MOTOR, "gain", 2.0)),
        (MOTOR.of_settings, lambda change: change.setattr(Settings, "gain", 2.0)),
        (Motor(inner=MOTOR).of_settings, lambda change: change.setattr(MOTOR, "gain", 2.0)),
        (jax.jit(MOTOR), lambda change: change.setattr(MOTOR, "gain", 2.0)),
        (jax.vmap(jax.jit(of_class)), lambda change: change.setattr(Settings, "gain", 2.0)),
        (np.vectorize(of_class), lambda change: change.setattr(Settings, "gain", 2.0)),
        (of_options, lambda change: change.setattr(OPTIONS, "gain", 2.0)),
        (of_arrays, lambda change: change.setitem(globals(), "NAMES", np.array(["c", "b"]))),
        (of_arrays, lambda change: change.setitem(globals(), "RECORD", np.ones(1, RECORD.dtype))),
        (of_held, lambda change: change.setitem(globals(), "HELD", [*HELD[:0], Fraction(1, 3), *HELD[1:]])),
        (
            of_held,
            lambda change: change.setitem(
                globals(), "HELD", [*HELD[:1], CubicSpline([0, 1, 2], [0, 2, 4]), *HELD[2:]]
            ),
        ),
    ],
)
def test_what_a_function_reads_by_other_objects_is_part_of_it(function, change, monkeypatch):
    before = content(function)
    assert content(function) == before
    change(monkeypatch)
    assert content(function) != before


def test_what_no_function_uses_is_not_part_of_it(monkeypatch):
    before = content(of_module), content(MOTOR)
    monkeypatch.setattr(MODULE, "unused", 2.0)
    monkeypatch.setattr(Settings, "gain", 2.0)  # read by a method that the call does not use
    assert before == (content(of_module), content(MOTOR))


def test_a_module_of_a_user_may_have_the_name_of_one_of_pythons(monkeypatch, tmp_path):
    (tmp_path / "tabnanny.py").write_text("SPEED = 1.0\ndef law(t):\n    return SPEED * t\n")
    (tmp_path / "imported_late.py").write_text("SPEED = 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "tabnanny", raising=False)
    module = importlib.import_module("tabnanny")

    def late(t):
        from imported_late import SPEED

        return SPEED * t

    before = content(module.law), content(late)
    module.SPEED = 2.0
    (tmp_path / "imported_late.py").write_text("SPEED = 2.0\n")
    assert content(module.law) != before[0]
    assert content(late) != before[1]
    monkeypatch.delitem(sys.modules, "tabnanny")

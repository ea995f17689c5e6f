"""A run uses the present values of the variables that a user's functions read."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.body import RigidBody
from supple.integrate import FixedStep, Run
from supple.machine import (
    GROUND,
    At,
    Controller,
    DeadForce,
    ForceBetween,
    Placed,
    System,
    TimeFunction,
    TorqueBetween,
)
from supple.quantities import SpringForceSensor
from supple.simulation import simulate
from supple.simulation.description import inputs_of

LEVEL = 1.0
RUN = Run(1.0, 0.5, step=FixedStep(0.1))
BOX = RigidBody("box", 2.0, [0, 0, 0], np.eye(3), {"centre": [0, 0, 0]})


def level(_time):
    return LEVEL


def pushed():
    """Pushed along x by the level, and turned about z by a controller."""
    push = DeadForce(body="box", at="centre", force=lambda t: np.array([1.0, 0.0, 0.0]) * level(t))
    motor = TorqueBetween(first=GROUND, second=At("box", "centre"), axis=(0, 0, 1))
    control = Controller(reads={}, drives={"motor": motor}, outputs=lambda t, _r, _z: {"motor": level(t)})
    return System((Placed(BOX),), loads=(push,), controllers=(control,))


def moved(solution):
    """Displacement along x, and angular velocity about z, at the end."""
    motion = solution.bodies["box"]
    return motion.position[-1, 0], motion.angular_velocity[-1, 2]


@pytest.mark.parametrize("again", [lambda system: system, lambda _: pushed()])
def test_a_second_run_of_the_same_functions(monkeypatch, again):
    """x = F t^2 / 2 m and w = M t / J."""
    system = pushed()
    monkeypatch.setitem(globals(), "LEVEL", 1.0)
    before = inputs_of(system, RUN, "case")
    assert moved(simulate(system, RUN)) == pytest.approx((0.25, 1.0), rel=1e-12)
    monkeypatch.setitem(globals(), "LEVEL", 3.0)
    system = again(system)
    assert moved(simulate(system, RUN)) == pytest.approx((0.75, 3.0), rel=1e-12)
    assert inputs_of(system, RUN, "case") != before


def test_a_law_keeps_its_program_while_nothing_changes():
    assert jax.tree.structure(TimeFunction(level)) == jax.tree.structure(TimeFunction(level))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class OwnLaw:
    size: float
    begin, end = -np.inf, np.inf

    def __call__(self, time):
        return LEVEL * self.size * jnp.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class OwnElement(ForceBetween):
    @staticmethod
    def wrenches(first, second, value, parameters):
        return ForceBetween.wrenches(first, second, LEVEL * value, parameters)


PUSH = OwnElement(first=GROUND, second=At("box", "centre"), axis=(1, 0, 0), force=1.0)


@pytest.mark.parametrize("load", [DeadForce(body="box", at="centre", force=OwnLaw(1.0)), PUSH])
def test_a_second_run_of_a_law_and_an_element_of_the_users(monkeypatch, load):
    """x = F t^2 / 2 m."""
    system = System((Placed(BOX),), loads=(load,))
    for level in (1.0, 3.0):
        monkeypatch.setitem(globals(), "LEVEL", level)
        solution = simulate(system, RUN)
        assert solution.bodies["box"].position[-1, 0] == pytest.approx(0.25 * level, rel=1e-12)
        if load is PUSH:
            force = SpringForceSensor("push", load).values(system, solution)
            assert force[-1, 0] == pytest.approx(level, rel=1e-12)

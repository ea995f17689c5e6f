"""A law written in Python that JAX cannot trace is refused with its name, its joint and the remedy."""

from __future__ import annotations

import math

import jax.numpy as jnp
import numpy as np
import pytest

import supple as sp
from supple.errors import ArgumentError, ModelError
from supple.machine import Scaled

HUB = sp.RigidBody("hub", 1.0, np.zeros(3), np.eye(3), {"centre": np.zeros(3)})


def turned_by(angle):
    joint = sp.PrescribedRotation(
        first="ground", second="hub.centre", axis=(0, 0, 1), angle=angle, name="motor"
    )
    return sp.System((sp.Placed(HUB),), (joint,))


def switched(time):
    return 1.0 if time > 0.5 else 0.0


def clipped(time):
    return max(time, 0.5)


def of_math(time):
    return math.sin(time)


def counted(time):
    return float(int(time))


def picked(time):
    return [0.0, 1.0][time]


def of_numpy(time):
    return np.sin(time)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (switched, r"\(switched\) branches on a condition of the time .*jnp\.where"),
        (clipped, r"\(clipped\) branches on a condition of the time .*jnp\.where"),
        (of_math, r"\(of_math\) converts the time to a Python number .*jnp\.sin.*jnp\.where"),
        (counted, r"\(counted\) converts the time to a Python number .*jnp\.where"),
        (picked, r"\(picked\) fails: TypeError: .*jnp\.where"),
        (of_numpy, r"must be written with jax\.numpy, not numpy \(of_numpy\)"),
        (lambda: 1.0, r"<lambda>\) fails: TypeError: .*takes 0 positional arguments"),
        (lambda time: missing, r"fails: NameError: name 'missing' is not defined"),  # noqa: F821
        (lambda time: "a", "returns no numbers"),
        (lambda time: None, "returns no numbers"),
        (lambda time: time > 0.5, r"of the kind bool; give real numbers, .*jnp\.where"),
        (lambda time: 1j * time, "of the kind complex128; give real numbers"),
        (lambda time: [time, time], r"values over time have shape \(2,\)"),
    ],
)
def test_what_jax_cannot_trace(law, message):
    with pytest.raises(ModelError, match=f"joint 'motor': .*{message}"):
        turned_by(law)


def test_the_remedy_works():
    turned_by(lambda time: jnp.where(time > 0.5, 1.0, 0.0))


@pytest.mark.parametrize("law", ["1.0", None, sp.Ramp, {"value": 1.0}, ["0", "1"], object()])
def test_what_is_no_law(law):
    with pytest.raises(
        ArgumentError, match=r"joint 'motor': .*expected a number, an array, a law such as Ramp"
    ):
        turned_by(law)


@pytest.mark.parametrize("law", [switched, of_math, of_numpy])
def test_laws_within_laws(law):
    with pytest.raises(ModelError, match=rf"\({law.__name__}\)"):
        Scaled((0.0, 0.0, 1.0), law)
    force = sp.DeadForce(at="hub.centre", force=sp.Turning((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), law))
    with pytest.raises(ModelError, match=rf"DeadForce on 'centre' of 'hub': .*\({law.__name__}\)"):
        sp.System((sp.Placed(HUB),), loads=(force,))

"""Small machines of soft strips, for the error equation against their full runs."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import jax.numpy as jnp
import numpy as np

from supple.body import (
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidBody,
    RigidInterface,
    flexible_body,
)
from supple.fem import HomogeneousSection, Isotropic, shell_model
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    Placed,
    PrescribedRotation,
    Prismatic,
    Revolute,
    SpringDamper,
    System,
)
from supple.mesh import strip
from supple.reduction import (
    CompressedDerivatives,
    CraigBampton,
    PlainQuartic,
    project,
    reduction_basis,
)

NODAL, MEAN = NodalFixedFrame("root"), MeanAxisFrame()
PLAIN = PlainQuartic()


@cache
def soft_strip(name, length, cells=4):
    """A strip of shells along x with interfaces at both ends; about 100 freedoms."""
    wall = HomogeneousSection(Isotropic(1e9, 0.3, 1000.0), 0.01)
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    return flexible_body(name, shell_model(strip(length, 0.1, cells, 2), wall), ends)


def run_of(duration, step=0.01, residual=1e-9, **options):
    return Run(
        duration=duration,
        output_step=step,
        step=FixedStep(step, smallest=1e-5),
        tolerances=Tolerances(residual=residual),
        **options,
    )


def spinning(frame, damping=None):
    """A strip driven about its width."""
    body = FullBody(soft_strip("strip", 1.0), frame, damping)
    hinge = PrescribedRotation(
        name="hinge", first=GROUND, second=At("strip", "root"), axis=(0, -1, 0), angle=lambda t: 1.6 * t**3
    )
    return System((Placed(body),), (hinge,)), run_of(1.0)


def pulse(t):
    """A bell of 0.05 s about 0.2 s."""
    return jnp.exp(-(((t - 0.2) / 0.05) ** 2))


def tumbling():
    """A free strip that is thrown turning, and pushed at its end."""
    body = FullBody(soft_strip("strip", 1.0), MEAN)
    push = DeadForce(body="strip", at=[0], force=lambda t: np.array([0.0, 0.0, 2.0]) * pulse(t))
    return (
        System((Placed(body, velocity=(0, 0, 1.0), angular_velocity=(2.0, 0.5, 1.0)),), (), (push,)),
        run_of(1.0),
    )


def hanging(frame):
    """Two strips in a row that fall from the horizontal."""
    upper, lower = soft_strip("upper", 0.5, 3), soft_strip("lower", 0.4, 3)
    return (
        System(
            (Placed(FullBody(upper, frame)), Placed(FullBody(lower, frame), position=(0.5, 0, 0))),
            (
                Revolute(name="hinge", first=GROUND, second=At("upper", "root"), axis=(0, 1, 0)),
                Revolute(name="elbow", first=At("upper", "tip"), second=At("lower", "root"), axis=(0, 1, 0)),
            ),
            gravity=(0, 0, -9.81),
        ),
        run_of(0.5),
    )


def slider_crank(frame):
    """A rigid crank that drives a flexible rod, and a slider: a closed loop."""
    rod = FullBody(soft_strip("rod", 0.6), frame)
    crank = RigidBody("crank", 0.5, [0.1, 0, 0], 0.01 * np.eye(3), {"pin": [0.2, 0, 0], "hub": [0, 0, 0]})
    slider = RigidBody("slider", 0.2, [0, 0, 0], 0.001 * np.eye(3), {"eye": [0, 0, 0]})
    return (
        System(
            (
                Placed(crank),
                Placed(rod, position=(0.2, 0, 0)),
                Placed(slider, position=(0.8, 0, 0)),
            ),
            (
                PrescribedRotation(
                    name="drive",
                    first=GROUND,
                    second=At("crank", "hub"),
                    axis=(0, -1, 0),
                    angle=lambda t: 4.0 * t**3,
                ),
                Revolute(name="pin", first=At("crank", "pin"), second=At("rod", "root"), axis=(0, 1, 0)),
                Revolute(name="eye", first=At("rod", "tip"), second=At("slider", "eye"), axis=(0, 1, 0)),
                Prismatic(name="guide", first=GROUND, second=At("slider", "eye"), axis=(1, 0, 0)),
            ),
        ),
        run_of(0.6),
    )


def sprung(frame):
    """A strip on a ball joint, caught by a spring and a damper at its end."""
    body = FullBody(soft_strip("strip", 1.0), frame)
    spring = SpringDamper(
        first=GROUND,
        second=At("strip", "tip"),
        stiffness=50.0,
        damping=0.5,
        rest_length=0.5,
        anchor=(1.0, 0.0, 0.5),
    )
    hinge = Revolute(name="hinge", first=GROUND, second=At("strip", "root"), axis=(0, 1, 0))
    return System((Placed(body),), (hinge,), (spring,), gravity=(0, 0, -9.81)), run_of(0.5)


def reduced(system, n_modes, n_derivatives, quartic=PLAIN):
    """The system with its full bodies reduced, and their bases."""
    fulls = system.bodies_of(FullBody)
    bases = {
        name: reduction_basis(
            full.body, full.frame, CraigBampton(n_modes), derivatives=CompressedDerivatives(n_derivatives)
        )
        for name, full in fulls.items()
    }
    bodies = {
        name: project(full.body, bases[name], damping=full.damping, quartic=quartic)
        for name, full in fulls.items()
    }

    def placed(each):
        name = each.body.name
        if name not in bodies:
            return each
        onto = bases[name].vectors.T @ fulls[name].body.mass
        return replace(
            each,
            body=bodies[name],
            coordinates=onto @ each.coordinates,
            coordinate_rates=onto @ each.coordinate_rates,
        )

    return replace(system, bodies=tuple(placed(each) for each in system.bodies)), bases


def nodal_errors(system, small, reference, solution):
    """True error of every node of every full body, (t, N, 3), by name."""
    placed = {each.body.name: each.body for each in small.bodies}
    return {
        name: full.positions(reference.bodies[name]) - placed[name].positions(solution.bodies[name])
        for name, full in system.bodies_of(FullBody).items()
    }


def rms(errors):
    return np.sqrt(np.mean(np.sum(errors**2, axis=2), axis=1))

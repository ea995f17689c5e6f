"""A machine of bars in every form, in a motion that is made up."""

import numpy as np
import pytest
from fixtures.bar_of_every_form import bar_as, model
from scipy.spatial.transform import Rotation

from supple.integrate import FloatingMotion, Solution, Statistics
from supple.machine import GROUND, At, Fixed, Placed, Revolute, System
from supple.methods.explicit import NodalMotion
from supple.methods.intrinsic import IntrinsicMotion

FORMS = ("rigid", "reduced", "full", "intrinsic", "modal", "finite elements")
N_TIMES = 5


def flown(n_coordinates, rng):
    """A frame that turns and moves, and a deformation."""
    zeros, still = np.zeros((N_TIMES, 3)), np.zeros((N_TIMES, n_coordinates))
    return FloatingMotion(
        rng.normal(size=(N_TIMES, 3)),
        Rotation.random(N_TIMES, rng=rng).as_matrix(),
        1e-3 * rng.normal(size=(N_TIMES, n_coordinates)),
        zeros,
        zeros,
        still,
        zeros,
        zeros,
        still,
    )


def nodal(nodes, n_elements, rng):
    """Nodes at places of their own; from the third time on the last element is gone."""
    alive = np.ones((N_TIMES, n_elements))
    alive[2:, -1] = 0
    moved = nodes + rng.normal(size=(N_TIMES, *nodes.shape))
    strain, stress = rng.uniform(size=(2, N_TIMES, n_elements))
    return NodalMotion(moved, 0 * moved, 0 * moved, strain, alive, 1e6 * stress)


@pytest.fixture(scope="package")
def machine():
    """The system and its motion; bodies named by their forms, the rigid one on a hinge."""
    rng = np.random.default_rng(0)
    placed, motions = [], {}
    for number, form in enumerate(FORMS):
        body = bar_as(form, form)
        placed.append(Placed(body, np.array([0.0, number, 0.0]), np.array([0.0, 0.0, 0.1 * number])))
        if form == "intrinsic":
            e = body.n_coordinates
            own = flown(e, rng)
            rates = np.zeros((N_TIMES, body.modes.n_rigid + e))
            motions[form] = IntrinsicMotion(
                own.position, own.rotation, own.coordinates, own.velocity, own.angular_velocity, rates
            )
        elif form == "finite elements":
            motions[form] = nodal(body.nodes, 8, rng)
        else:
            motions[form] = flown(body.n_coordinates, rng)
    hinge = Revolute(name="hinge", first=GROUND, second=At("rigid", "root"), axis=(0, 1, 0))
    weld = Fixed(name="weld", first=At("reduced", "tip"), second=GROUND)
    system = System(placed, [hinge, weld])
    return system, Solution(np.linspace(0, 1, N_TIMES), motions, {}, Statistics())


@pytest.fixture(scope="package")
def meshes():
    return {form: model().mesh for form in FORMS if form != "rigid"}


@pytest.fixture(scope="package")
def elements():
    return {form: model() for form in FORMS if form != "rigid"}

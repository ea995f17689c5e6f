"""A base that shakes: effective masses of a beam, and the random response of an oscillator."""

from __future__ import annotations

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body

from supple.body import MeanAxisFrame, NodalFixedFrame, RigidBody
from supple.errors import ModelError
from supple.linearization import (
    Acceleration,
    BaseAccelerationPort,
    TranslationPort,
    effective_masses,
    frequency_response,
    linearize,
    machine_modes,
    random_response,
    state_space,
)
from supple.machine import Fixed, Placed, Prismatic, Spin, SpringDamper, System
from supple.reduction import CraigBampton, NoLoads, reduce

LENGTH, AWAY = 4.0, 3.0
SHAKEN = BaseAccelerationPort((2, 0, 0))


@pytest.fixture(scope="module")
def oscillator():
    """A mass of 3 kg on a slide along x, with a spring and a damper: 20 rad/s, damping ratio 0.02."""
    stone = RigidBody("stone", 3.0, np.zeros(3), np.eye(3), {"top": np.zeros(3)})
    spring = SpringDamper(
        first="ground", second="stone.top", anchor=(5, 0, 0), stiffness=1200.0, damping=2.4, rest_length=5.0
    )
    slide = Prismatic(first="ground", second="stone.top", axis=(1, 0, 0))
    return linearize(System([stone], [slide], [spring]))


@pytest.mark.parametrize("frame", [MeanAxisFrame(), NodalFixedFrame("root")], ids=["mean", "nodal"])
def test_a_clamped_beam_has_the_effective_masses_of_its_formula(frame):
    """0.6131, 0.1883, 0.0647 of the mass, 0.9707 of the inertia about the root; root at 3 m, turned to y."""
    body = reduce(beam_body("root", "tip", n=40, length=LENGTH), frame, CraigBampton(30), loads=NoLoads)
    placed = Placed(body, position=(0, AWAY, 0), rotation=(0, 0, np.pi / 2))
    modes = machine_modes(linearize(System([placed], [Fixed(first="ground", second="beams.root")]), fulls=()))
    found = effective_masses(modes)
    assert found.shape == (len(modes.eigenvalues), 6)
    flap = found[found[:, 2] > 1e-6 * body.mass][:3] / body.mass
    assert flap[:, 2] == pytest.approx([0.6131, 0.1883, 0.0647], rel=1e-2)  # rotary inertia
    # About x, through the origin: each particle at a distance r from the root moves by 3 m + r.
    about = (np.sqrt(0.9707 / 3) * LENGTH + AWAY * np.sqrt(0.6131)) ** 2
    assert flap[0, 3] == pytest.approx(about, rel=3e-3)
    assert found[:, :3].sum(axis=0) == pytest.approx(np.full(3, body.mass), rel=0.05)


def test_white_noise_of_the_base_shakes_an_oscillator_as_miles_says(oscillator):
    """`pi w Q S / 2 (1 + 1 / Q^2)`, absolute; relative to the base `1 / w^2` at rest."""
    top = TranslationPort("stone.top", (1, 0, 0))
    space = state_space(oscillator, inputs=[SHAKEN], outputs=[top, Acceleration(top)])
    assert space.inputs == ("acceleration of the base along x",)
    still = frequency_response(space, [1e-9]).transfer[0, :, 0]
    assert still == pytest.approx([-1 / 400, 1.0], rel=1e-9)
    w = np.geomspace(0.01, 1e5, 40_000)
    density, quality = 7.0, 25.0
    rms = random_response(frequency_response(space, w), np.full(len(w), density)).rms[1]
    assert rms**2 == pytest.approx(np.pi / 2 * 20 * quality * density * (1 + quality**-2), rel=1e-3)
    assert effective_masses(machine_modes(oscillator))[0] == pytest.approx([3, 0, 0, 0, 0, 0], abs=1e-12)


def test_what_a_base_cannot_be_is_refused(oscillator):
    with pytest.raises(ModelError, match=r"direction of the base's acceleration must be three numbers"):
        BaseAccelerationPort((0, 0, 0))
    with pytest.raises(ModelError, match=r"is an input; as output give ports of the bodies"):
        state_space(oscillator, inputs=[SHAKEN], outputs=[Acceleration(SHAKEN)])
    top = RigidBody("top", 1.0, np.zeros(3), np.diag([1.0, 1.0, 1.5]), {})
    turning = linearize(System([top]), spin=Spin(1.0, (0, 0, 1)))
    with pytest.raises(ModelError, match=r"does not rotate: leave out spin"):
        effective_masses(machine_modes(turning))

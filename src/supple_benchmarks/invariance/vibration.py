"""Large free vibration of a slender box of beams, compared with a geometrically exact beam.

The deflection is about a quarter of the length.
"""

from __future__ import annotations

import numpy as np

from supple.body import FullBody
from supple.integrate import FixedStep, GeneralizedAlpha, Run, Tolerances
from supple.machine import GROUND, At, DeadForce, Fixed, Placed, System, Table
from supple.quantities import node_positions
from supple.reduction import ReducedBody
from supple.simulation import simulate
from supple_benchmarks.compared_models import FRAMES
from supple_benchmarks.invariance.box import BOX_LENGTH, SECTION, beam_stiffness, box_of_beams, weak_bending
from supple_benchmarks.invariance.clamped import clamped_body
from supple_benchmarks.references.simo_reissner import straight_beam, swung
from supple_benchmarks.table import Row

__all__ = ["box_vibration", "pushed", "swinging_tip"]

STEP = 0.01
PUSH = 1.0
"""Duration of the force at the tip, s."""
RHO_INF = 0.9


def pushed(duration: float, deflection: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) and tip forces (t, 3) of a smooth push along z and half of it along y, then without force.

    deflection : static deflection along z under the largest force, over the length
    """
    times = STEP * np.arange(round(duration / STEP) + 1)
    size = 3 * weak_bending() * deflection / BOX_LENGTH**2
    pulse = np.where(times < PUSH, np.sin(np.pi * times / PUSH) ** 2, 0.0)
    return times, size * pulse[:, None] * [0.0, 0.5, 1.0]


def box_vibration(quick: bool) -> Row:
    """Error of the box of beams over time.

    error : largest distance of the tip from that of the exact beam, over the largest deflection of the latter
    swing : largest deflection of the exact beam, over the length;   t : duration, s
    """
    n, duration = (10, 1.5) if quick else (40, 5.0)
    times, forces = pushed(duration, 0.22)
    E = SECTION
    density = E.material.density
    exact = straight_beam(
        BOX_LENGTH,
        n // 2,
        beam_stiffness(),
        mass=density * E.area,
        inertia=density * np.array([E.I1 + E.I2, E.I2, E.I1]),
    )
    reference = swung(exact, forces, step=STEP, rho_inf=RHO_INF)[0][:, -1]
    form = FullBody(clamped_body("box", box_of_beams(n)), FRAMES["mean-axis"])
    found = swinging_tip(form, times, forces)
    swing = np.linalg.norm(reference - [BOX_LENGTH, 0, 0], axis=1).max()
    error = np.linalg.norm(found - reference, axis=1).max() / swing
    return {"t": duration, "error": float(error), "swing": float(swing / BOX_LENGTH), "elements": n}


def swinging_tip(form: FullBody | ReducedBody, times: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Positions (t, 3) of the tip node of the clamped box under forces (t, 3) on this node."""
    clamp = Fixed(first=GROUND, second=At(form.name, "root"), name="clamp")
    tip = [int(np.argmax(form.nodes[:, 0]))]
    load = DeadForce(body=form.name, at=np.array(tip), force=Table(times, forces[:, None, :]))
    run = Run(
        float(times[-1]),
        output_step=STEP,
        step=FixedStep(STEP),
        method=GeneralizedAlpha(RHO_INF),
        tolerances=Tolerances(residual=1e-8),
    )
    solution = simulate(System((Placed(form),), (clamp,), (load,)), run)
    return node_positions(form, solution.bodies[form.name], np.array(tip))[:, 0]

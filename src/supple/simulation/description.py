"""One-line description of a machine and its run, and named digests of all inputs of its motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from supple.body import FullBody, RigidBody
from supple.integrate import Run
from supple.machine import Placed, System
from supple.methods.explicit import Explicit, ExplicitShell, ExplicitSubdomain, ModalSubdomain
from supple.methods.explicit.method import explicit_method
from supple.methods.intrinsic import IntrinsicBody
from supple.reduction import ReducedBody
from supple.simulation.engines import is_explicit
from supple.storage.run_inputs import ORDER_OF_CONTROLLERS, Inputs
from supple.storage.value_bytes import bytes_of, digest_of_parts


def description(system: System, run: Run) -> str:
    """Names of bodies and joints, and the span of the run."""
    bodies = ", ".join(f"{placed.body.name} ({placed.body.kind})" for placed in system.bodies)
    joints = ", ".join(joint.name for joint in system.joints) or "none"
    span = f"{run.duration:g} from {run.start:g}, every {run.output_step:g}"
    return f"bodies {bodies}; joints {joints}; {span}"


def inputs_of(system: System, run: Run, case: str) -> Inputs:
    """Inputs of a motion by name: digests of bodies, joints, loads and other parts; the case and the run.

    A modal body is represented by the inputs of its modes. A reduced body is represented only by its form,
    position and initial motion, because a repeated reduction changes last digits and signs of modes;
    `recorded_columns` identifies its basis.
    """
    if is_explicit(system, run):
        run = replace(run, method=explicit_method(run))
    span = f"{run.duration!r} from {run.start!r}, every {run.output_step!r}"
    found = {"the case": case, "the run": f"{span}, {run.step_control}, {run.method}, {run.tolerances}"}
    found["the order of the bodies"] = ", ".join(placed.body.name for placed in system.bodies)
    found |= {f"body '{placed.body.name}'": digest_of_parts(_of_body(placed)) for placed in system.bodies}
    found |= {f"joint '{joint.name}'": digest_of_parts(bytes_of(joint)) for joint in system.joints}
    found |= {
        f"load {i + 1}, {load.label}": digest_of_parts(bytes_of(load)) for i, load in enumerate(system.loads)
    }
    found |= {f"controller '{own.name}'": digest_of_parts(bytes_of(own)) for own in system.controllers}
    if len(system.controllers) > 1:  # stored states are numbered
        found[ORDER_OF_CONTROLLERS] = ", ".join(own.name for own in system.controllers)
    for item in ("ties", "contacts", "supports"):
        found |= {
            f"{item[:-1]} {number} of '{each.nodes}'": digest_of_parts(bytes_of(each))
            for number, each in enumerate(getattr(system, item), 1)
        }
    if run.step is None and isinstance(run.method, Explicit):
        found["the step"] = "what is stable"
    return found | {"gravity": digest_of_parts(bytes_of(system.gravity))}


def _of_body(placed: Placed) -> Iterator[bytes]:
    body = placed.body
    yield f"{body.kind} {body.n_coordinates}".encode()
    for item in ("position", "rotation", "velocity", "angular_velocity"):
        yield from bytes_of(getattr(placed, item))
    match body:
        case RigidBody():
            yield from bytes_of((body.mass, body.centre, body.inertia, body.points))
        case FullBody() | ExplicitSubdomain() | ExplicitShell():
            yield from bytes_of(body)
        case ModalSubdomain():
            spun = body.spin_stiffness is not None
            yield from bytes_of((body.body, body.mass_damping, body.stiffness_damping, spun))
        case IntrinsicBody():
            yield from bytes_of((body.support, body.damping))
        case ReducedBody():
            yield from bytes_of((body.frame, body.is_linear))
        case _:
            yield from bytes_of(body)

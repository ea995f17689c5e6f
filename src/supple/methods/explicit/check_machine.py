"""What an explicit march does not do, refused in one sentence before anything is compiled."""

from __future__ import annotations

import numpy as np

from supple.errors import ModelError
from supple.integrate import ExplicitRule, GeneralizedAlpha, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    EndReading,
    ForceElement,
    JointFriction,
    Mortar,
    NodalLoad,
    Support,
    System,
    Tie,
)
from supple.methods.explicit.explicit_shell import ExplicitShell
from supple.methods.explicit.method import Explicit
from supple.methods.explicit.modal_subdomain import ModalSubdomain
from supple.methods.explicit.projected_difference import ProjectedDifference
from supple.methods.explicit.start_motion import rigid_velocities, undeformed

__all__ = ["check_machine", "check_run", "check_spun"]

_APART = 1e-9
"""Of the fastest point: by how much the velocities of two tied modal parts may differ at the start."""
_ROUNDED = 1e-6
"""The same of explicit nodes, whose velocity is that of the part that leads them."""


def check_spun(system: System) -> None:
    """ModelError for modal parts whose stiffness of their own spin statics and modes would leave out."""
    for name, part in system.bodies_of(ModalSubdomain).items():
        if part.spin_stiffness is not None:
            raise ModelError(
                f"part '{name}' has a stiffness of its spin (`CentrifugalStiffness`, spin_stiffness = true), "
                "which the explicit march alone takes: for rest and modes of a machine that turns, reduce "
                "the body, or leave that stiffness out"
            )


def check_machine(system: System, method: Explicit) -> None:
    """ModelError for bodies of other methods, and for what acts on parts that does not suit them."""
    for placed in system.bodies:
        body = placed.body
        if body.kind not in ("modal", "explicit", "rigid"):
            raise ModelError(
                f"body '{body.name}' is {body.kind}, which does not march explicitly: make it a "
                "modal_subdomain or an explicit_subdomain"
            )
        if body.kind == "explicit" and placed.coordinates.any():
            raise ModelError(
                f"part '{body.name}' is of finite elements, which start undeformed, for the energy that they "
                "would hold is not known: leave its coordinates out; coordinate_rates may be given"
            )
    for controller in system.controllers:
        what = f"controller '{controller.name}'"
        seen = [reading.at for reading in controller.reads.values() if isinstance(reading, EndReading)]
        driven = [end for each in controller.drives.values() for end in (each.first, each.second)]
        _check_frames(system, what, (*seen, *driven))
    for joint in system.joints:
        _check_frames(system, f"joint '{joint.name}'", (joint.first, joint.second))
    _check_scheme(system, method)
    for load in system.loads:
        _check_load(system, load)
    for support in system.supports:
        _check_support(system, support)
    for tie in system.ties:
        _check_tie(system, tie)


def _check_scheme(system: System, method: Explicit) -> None:
    modal = system.bodies_of(ModalSubdomain)
    stiffened = [name for name, body in modal.items() if body.spin_stiffness is not None]
    if stiffened and not isinstance(method.scheme, ProjectedDifference):
        raise ModelError(
            f"part '{stiffened[0]}' stiffens as it spins, which {type(method.scheme).__name__} does not "
            "know; take ProjectedDifference(), or leave `stiffening` out"
        )


def _check_load(system: System, load: object) -> None:
    if isinstance(load, JointFriction):
        raise ModelError(
            f"{load.label}: an explicit march does not follow the force of a joint; give friction a preload, "
            "RevoluteFriction or PrismaticFriction"
        )
    if isinstance(load, ForceElement):
        _check_frames(system, load.label, (load.first, load.second))
    elif isinstance(load, NodalLoad) and not (isinstance(load, DeadForce) or _has_frame(system, load.body)):
        raise ModelError(f"{load.label}: nodes of explicit elements bear DeadForce alone; give this")


def _check_frames(system: System, what: str, ends: tuple[At, ...]) -> None:
    """ModelError where an end is on explicit elements, which have no frame."""
    for end in ends:
        if end != GROUND and not _has_frame(system, end.body):
            raise ModelError(
                f"{what}: it takes hold of a frame, and nodes of explicit elements ('{end.body}') have none; "
                "put it on a modal part that they are tied on, or give a DeadForce"
            )


def _has_frame(system: System, name: str) -> bool:
    return system.placed(name).body.has_frame


def _is_modal(system: System, name: str) -> bool:
    return system.placed(name).body.kind == "modal"


def _check_support(system: System, support: Support) -> None:
    part = support.nodes.body
    if _is_modal(system, part):
        raise ModelError(
            f"support of '{support.nodes}': '{part}' is modal, and flies free on its frame; hold nodes of an "
            "explicit part that is tied on it elsewhere"
        )
    most = 6 if isinstance(system.placed(part).body, ExplicitShell) else 3
    if not all(0 <= axis < most for axis in support.axes):
        raise ModelError(
            f"support of '{support.nodes}': axes {support.axes}; give 0 to {most - 1}, rotations of shells "
            "alone"
        )


def _check_tie(system: System, tie: Tie) -> None:
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    if tie.on == tie.nodes.body:
        raise ModelError(f"tie of '{tie.nodes}': a part is not tied to itself, give another as `on`")
    modal, modal_on = _is_modal(system, tie.nodes.body), _is_modal(system, tie.on)
    if isinstance(tie.transfer, Mortar) and not modal_on:
        raise ModelError(
            f"{what}: a mortar needs a modal part to hang on; explicit parts are tied node to node"
        )
    if modal and not modal_on:
        raise ModelError(
            f"{what}: nodes of a modal sub-domain are tied on a modal one, and '{tie.on}' is explicit; tie "
            f"its nodes on '{tie.nodes.body}' instead"
        )
    first, second = system.placed(tie.nodes.body), system.placed(tie.on)
    x = undeformed(first)[system.node_numbers(tie.nodes)]
    one, two = rigid_velocities(first, x), rigid_velocities(second, x)
    fastest = max(np.linalg.norm(one, axis=1).max(), np.linalg.norm(two, axis=1).max())
    apart = float(np.linalg.norm(one - two, axis=1).max())
    if apart > (_APART if modal else _ROUNDED) * fastest:
        raise ModelError(
            f"{what}: at the start the two sides fly apart by {apart:.3g} m/s; tied parts start as one: give "
            "both the velocity and angular velocity of one rigid motion"
        )


def check_run(run: Run) -> None:
    """ModelError for what a run asks and the march does not do."""
    if not isinstance(run.method, ExplicitRule) and run.method != GeneralizedAlpha():
        raise ModelError(
            f"explicit parts march by central differences, not by {type(run.method).__name__}: leave the "
            "method of the run out; Explicit(scheme=...) chooses that of the modal parts"
        )
    if run.tolerances != Tolerances():
        raise ModelError("an explicit march iterates nothing: leave the tolerances of the run out")

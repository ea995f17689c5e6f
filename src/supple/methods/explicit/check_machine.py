"""Checks of a machine and a run for explicit time integration, before anything is compiled."""

from __future__ import annotations

from supple.errors import ModelError
from supple.integrate import ExplicitRule, GeneralizedAlpha, Run, Tolerances
from supple.machine import (
    GROUND,
    At,
    DeadForce,
    EndReading,
    FollowerPressure,
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


def check_spin_stiffness(system: System) -> None:
    """Raise ModelError for modal parts with a centrifugal stiffness, which statics and modes neglect."""
    for name, part in system.bodies_of(ModalSubdomain).items():
        if part.spin_stiffness is not None:
            raise ModelError(
                f"part '{name}' has a centrifugal stiffness (`CentrifugalStiffness`, spin_stiffness = true), "
                "which only explicit time integration supports: for equilibrium and modes of a rotating "
                "machine, reduce the body, or omit this stiffness"
            )


def check_machine(system: System, method: Explicit) -> None:
    """Raise ModelError for parts of a system that explicit time integration does not support."""
    for placed in system.bodies:
        body = placed.body
        if body.kind not in ("modal", "explicit", "rigid"):
            raise ModelError(
                f"body '{body.name}' is {body.kind}, which explicit time integration does not support: use "
                "modal_subdomain or explicit_subdomain"
            )
        if body.kind == "explicit" and placed.coordinates.any():
            raise ModelError(
                f"part '{body.name}' has finite elements, which start undeformed (their initial energy is "
                "unknown otherwise): omit its coordinates; coordinate_rates may be given"
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
            f"part '{stiffened[0]}' has a centrifugal stiffness (`stiffening`, spin_stiffness = true), which "
            f"{type(method.scheme).__name__} does not support; use ProjectedDifference(), or omit it"
        )


def _check_load(system: System, load: object) -> None:
    if isinstance(load, JointFriction):
        raise ModelError(
            f"{load.label}: explicit time integration does not include the force of a joint in its friction; "
            "use RevoluteFriction or PrismaticFriction, with a preload"
        )
    if isinstance(load, ForceElement):
        _check_frames(system, load.label, (load.first, load.second))
    elif (
        isinstance(load, NodalLoad)
        and not isinstance(load, DeadForce | FollowerPressure)
        and not _has_frame(system, load.body)
    ):
        raise ModelError(
            f"{load.label}: nodes of explicit elements support DeadForce and FollowerPressure only"
        )


def _check_frames(system: System, what: str, ends: tuple[At, ...]) -> None:
    """Raise ModelError where an end is on explicit elements, which have no frame."""
    for end in ends:
        if end != GROUND and not _has_frame(system, end.body):
            raise ModelError(
                f"{what}: it needs a frame, and nodes of explicit elements ('{end.body}') have none; "
                "put it on a modal part to which these nodes are tied, or use a DeadForce"
            )


def _has_frame(system: System, name: str) -> bool:
    return system.placed(name).body.has_frame


def _is_modal(system: System, name: str) -> bool:
    return system.placed(name).body.kind == "modal"


def _check_support(system: System, support: Support) -> None:
    part = support.nodes.body
    if _is_modal(system, part):
        raise ModelError(
            f"support of '{support.nodes}': '{part}' is modal, and its frame is free; fix nodes of an "
            "explicit part that is tied to it instead"
        )
    most = 6 if isinstance(system.placed(part).body, ExplicitShell) else 3
    if not all(0 <= axis < most for axis in support.axes):
        raise ModelError(
            f"support of '{support.nodes}': axes {support.axes}; give 0 to {most - 1} (3 to 5, in a case "
            "file rotations = true: rotations, of shells alone)"
        )


def _check_tie(system: System, tie: Tie) -> None:
    what = f"tie of '{tie.nodes}' on '{tie.on}'"
    if tie.on == tie.nodes.body:
        raise ModelError(f"tie of '{tie.nodes}': a part cannot be tied to itself; give another as `on`")
    if system.placed(tie.on).body.kind == "rigid":
        raise ModelError(
            f"{what}: '{tie.on}' is rigid and has no faces; tie the nodes on a modal part, and join that to "
            f"'{tie.on}', for example by a Fixed joint"
        )
    modal, modal_on = _is_modal(system, tie.nodes.body), _is_modal(system, tie.on)
    if isinstance(tie.transfer, Mortar) and not modal_on:
        raise ModelError(
            f"{what}: a mortar tie needs a modal part as `on`; explicit parts are tied node to node"
        )
    if modal and not modal_on:
        raise ModelError(
            f"{what}: nodes of a modal sub-domain can be tied only to another modal sub-domain, and "
            f"'{tie.on}' is explicit; tie the nodes of '{tie.on}' on '{tie.nodes.body}' instead"
        )


def check_explicit_run(run: Run) -> None:
    """Raise ModelError for run options that explicit time integration does not support."""
    if not isinstance(run.method, ExplicitRule) and run.method != GeneralizedAlpha():
        raise ModelError(
            f"explicit parts use central differences, not {type(run.method).__name__}: omit the method of "
            "the run, or give Explicit(scheme=...) for the scheme of the modal parts"
        )
    if run.tolerances != Tolerances():
        raise ModelError("explicit time integration has no iterations: omit the tolerances of the run")

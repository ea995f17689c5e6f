"""Frames of modal parts and rigid bodies in the model, with their ties, joints and forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy import linalg

from supple.arrays import FloatArray
from supple.body import RigidBody
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import CompiledMachine
from supple.equations.configuration import ControlState
from supple.equations.consistent_start import consistent_start
from supple.equations.control_start import first_control
from supple.equations.machine_model import Model
from supple.equations.start_change import StartChange
from supple.machine import ForceElement, Placed, System
from supple.methods.explicit.frame_chart import frame_chart, placed_state
from supple.methods.explicit.frame_model import FrameModel, FrameState
from supple.methods.explicit.march.build_joined import JoinedFrames, joined_frames
from supple.methods.explicit.march.build_obstacles import check_outside, recoil
from supple.methods.explicit.march.build_surfaces import MarchNodes, TiedNodes, touching_surfaces
from supple.methods.explicit.march.frame_forces import frame_states, stored_energy, storing_elements
from supple.methods.explicit.march.march_model import FrameArrays, NodesTouching
from supple.methods.explicit.march.touching_surface import TouchingSurface
from supple.methods.explicit.method import Explicit
from supple.methods.explicit.modal_frame import ModalFrame, modal_frame
from supple.methods.explicit.modal_subdomain import ModalSubdomain
from supple.methods.explicit.rigid_frame import RigidFrame
from supple.methods.explicit.start_motion import undeformed


@dataclass(frozen=True, eq=False)
class Framed:
    """Frames of the model.

    frames : parts and bodies in the order of the model, with their integrated modes
    arrays, states : arrays and initial state of each frame
    surfaces : contacts between parts;   contact_rate : largest stiffness of contacts over the mass of a node
        without a tie, 1/s^2
    joined : ties, joints and step limits
    machine : the frames as a system of floating bodies with their joints and forces, or None
    change : correction of the initial state by joints; None without joints
    stores, stored : whether each group of force elements stores energy, and the energy at the start, J
    control : state of the controllers; None without controllers
    """

    frames: dict[str, ModalFrame]
    arrays: tuple[FrameArrays, ...]
    states: tuple[FrameState, ...]
    surfaces: tuple[TouchingSurface, ...]
    contact_rate: float
    joined: JoinedFrames
    machine: System | None
    change: StartChange | None
    stores: tuple[bool, ...]
    stored: Array
    control: ControlState | None


def build_frames(system: System, method: Explicit, nodes: MarchNodes, time: float) -> Framed:
    """Frames of a model that starts at a time."""
    frames, arrays, states, penalties, recoils = {}, [], [], {}, {}
    for part in (placed for placed in system.bodies if placed.body.has_frame):
        name = part.body.name
        own = [each for each in nodes.tied if each.part == name]
        frames[name], own_arrays, state, penalties[name], recoils[name] = _frame(
            system, part, own, nodes.mass, nodes.x
        )
        arrays.append(own_arrays)
        states.append(state)
    surfaces, contact_rate, between = touching_surfaces(system, nodes, frames)
    pressed = {}
    for place, (name, frame) in enumerate(frames.items()):
        both = [each for each in (penalties[name], between.get(name)) if each is not None]
        pressed[name] = sum(both[1:], both[0]) if both else None
        limit = jnp.asarray(frame.step_limit(pressed[name]))
        arrays[place] = arrays[place]._replace(step_limit=limit)
    floating, machine, change = _floating(system, tuple(frames)), None, None
    if floating is not None:
        machine, change, states = _joined_start(floating, frames, states, time)
    joined = joined_frames(
        system, method.scheme, frames, tuple(arrays), tuple(states), pressed, machine, time
    )
    for place in joined.limited:
        recoiling = recoils[list(frames)[place]]
        of_obstacle = 2 / np.sqrt(recoiling) if recoiling else np.inf
        limit = jnp.asarray(min(joined.step_limit, of_obstacle))
        arrays[place] = arrays[place]._replace(step_limit=limit)
    stores, stored, control = (), jnp.zeros(()), None
    if floating is not None and joined.machine is not None:
        elements = [load for load in system.loads if isinstance(load, ForceElement)]
        stores = storing_elements(joined.machine, elements)
        at = joined.machine, tuple(arrays), tuple(states), jnp.asarray(time)
        stored = stored_energy(elements, stores, *at)
        if system.controllers:
            first = first_control(floating, joined.machine, jax.tree.map(np.asarray, frame_states(*at)))
            control = jax.tree.map(jnp.asarray, first)
    return Framed(
        frames,
        tuple(arrays),
        tuple(states),
        surfaces,
        contact_rate,
        joined,
        floating,
        change,
        stores,
        stored,
        control,
    )


def _floating(system: System, names: Sequence[str]) -> System | None:
    """The bodies on frames with their joints and forces; None without frames."""

    def acts(load: object) -> bool:
        if isinstance(load, ForceElement):
            return load.first.body in names or load.second.body in names
        return getattr(load, "body", None) in names

    if not names:
        return None
    return replace(
        system,
        bodies=tuple(placed for placed in system.bodies if placed.body.name in names),
        loads=tuple(load for load in system.loads if acts(load)),
        ties=(),
        contacts=(),
        supports=(),
    )


def _joined_start(
    floating: System, frames: dict[str, ModalFrame], states: list[FrameState], time: float
) -> tuple[Model, StartChange | None, list[FrameState]]:
    """The frames as floating bodies without redundant joint equations, and states that satisfy the joints."""
    model, change = build_model(floating), None
    if floating.joints:
        start = consistent_start(CompiledMachine(floating, model), time)
        model, change = start.machine.model, start.change
        origins, rotations, coordinates = start.configuration
        parts = zip(frames.values(), origins, rotations, model.coordinate_slices, model.slices, strict=True)
        states = [
            placed_state(frame, R, A, coordinates[own], start.velocity[part])
            for frame, R, A, own, part in parts
        ]
    return replace(model, groups=()), change, states


def _frame(
    system: System, part: Placed, tied: list[TiedNodes], mass: FloatArray, x: FloatArray
) -> tuple[ModalFrame, FrameArrays, FrameState, FloatArray | None, float]:
    """Frame, its arrays, state, the penalties of its obstacles, and squared frequency of a free obstacle."""
    body = RigidFrame(part.body) if isinstance(part.body, RigidBody) else part.body
    assert isinstance(body, RigidFrame | ModalSubdomain)
    nodes = np.concatenate([each.nodes for each in tied] or [np.empty(0, dtype=np.int64)])
    local = (x[nodes] - part.position) @ part.rotation
    shapes = np.concatenate(
        [np.einsum("nc,ncik->nik", each.weights, body.shapes[each.corners]) for each in tied]
        or [np.empty((0, 3, body.n_modes))]
    )
    frame = modal_frame(body, local, shapes, mass[nodes])
    touching, stiffest, largest = [], None, 0.0
    for number, contact in enumerate(system.rigid_contacts):
        if contact.nodes.body == body.name:
            own = system.node_numbers(contact.nodes)
            stiffness = frame.stiffness_at(own, contact.fraction)
            if contact.stiffness is not None:
                stiffness = np.full(len(own), contact.stiffness)
            nodes_at = undeformed(part)
            check_outside(contact, nodes_at[own], nodes_at)
            touching.append(
                NodesTouching(
                    jnp.asarray(own),
                    jnp.asarray(stiffness),
                    jnp.asarray(frame.weights(own)),
                    jnp.asarray(frame.shapes[own]),
                    number,
                    contact.obstacle,
                )
            )
            added = frame.penalty_stiffness(own, stiffness)
            if (back := recoil(contact.obstacle, nodes_at[own], stiffness)) > 0:
                alone = float(linalg.eigh(added, frame.pencil()[0], eigvals_only=True)[-1])
                added = added * (1 + back / alone)
                largest = max(largest, alone + back)
            stiffest = added if stiffest is None else stiffest + added
    points = body.points
    model: FrameModel = frame.model
    arrays = FrameArrays(
        model,
        jnp.asarray(nodes),
        jnp.asarray(points.weights(local)),
        jnp.asarray(shapes @ frame.turned),
        tuple(touching),
        frame_chart(frame),
        jnp.asarray(jnp.inf),  # set when all contacts are known
        None if frame.spin_bound is None else jnp.asarray(frame.spin_bound),
    )
    rates = np.concatenate([part.twist, part.coordinate_rates])
    start = placed_state(frame, part.position, part.rotation, part.coordinates, rates)
    return frame, arrays, start, stiffest, largest

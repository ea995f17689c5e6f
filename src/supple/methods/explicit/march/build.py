"""From a system to the arrays of its march: common nodes, mass that hangs on frames, contacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.body import RigidBody
from supple.equations.build_model import build_model
from supple.equations.compiled_machine import CompiledMachine
from supple.equations.configuration import Configuration
from supple.equations.consistent_start import consistent_start
from supple.equations.control_start import first_control
from supple.equations.model import Model
from supple.equations.start_change import StartChange
from supple.errors import ModelError
from supple.machine import At, BaseAcceleration, Contact, DeadForce, ForceElement, Placed, System, Tie
from supple.machine.ties.meeting import meeting_nodes
from supple.methods.explicit.elements import rest_layers
from supple.methods.explicit.frame_chart import frame_chart, placed_state
from supple.methods.explicit.frame_model import FrameModel, FrameState
from supple.methods.explicit.march.build_blocks import explicit_blocks
from supple.methods.explicit.march.build_joined import joined_frames
from supple.methods.explicit.march.build_shells import explicit_shells
from supple.methods.explicit.march.build_surfaces import Hanging, modal_skins, touching_surfaces
from supple.methods.explicit.march.build_ties import met_material, within
from supple.methods.explicit.march.frame_forces import frame_motion, stored_energy, storing_elements
from supple.methods.explicit.march.frame_step import hanging as hung_places
from supple.methods.explicit.march.march_step import with_forces
from supple.methods.explicit.march.model import (
    Energies,
    FrameArrays,
    MarchModel,
    MarchState,
    Methods,
    NodesTouching,
    ObstacleState,
)
from supple.methods.explicit.march.turning import Turning
from supple.methods.explicit.method import Explicit
from supple.methods.explicit.modal_frame import ModalFrame, modal_frame
from supple.methods.explicit.rigid_frame import RigidFrame
from supple.methods.explicit.start_motion import rigid_velocities, undeformed

__all__ = ["Built", "built"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Built:
    """A system ready to march.

    nodes : explicit part to the numbers of its nodes in the march
    blocks : explicit part of solids to its blocks among those of the march;   shells : likewise
    frames : modal parts and rigid bodies, in the order of the march, with their modes as marched
    machine : these as a system of floating bodies, with what joins them and acts on them; None without any
    change : by what joints changed their start;   None without joints
    """

    model: MarchModel
    methods: Methods
    start: MarchState
    nodes: dict[str, IntArray]
    blocks: dict[str, slice]
    shells: dict[str, slice]
    frames: dict[str, ModalFrame]
    machine: System | None
    change: StartChange | None


def built(system: System, method: Explicit, time: float = 0.0) -> Built:
    """The march of a system from a time on.

    Raises ModelError for ties that do not meet, nodes that begin inside an obstacle, joints that are open.
    """
    explicit = [placed for placed in system.bodies if placed.body.kind == "explicit"]
    numbers, x, v = _numbered(system, explicit)
    skins = modal_skins(system, len(x))
    for skin in skins:
        part = system.placed(skin.part)
        corners = undeformed(part)[skin.corners]
        x = np.vstack([x, corners])
        v = np.vstack([v, rigid_velocities(part, corners)])
    made = explicit_blocks(explicit, numbers, len(x))
    shells = explicit_shells(explicit, numbers, len(x))
    mass = made.mass + shells.mass
    alpha = (made.damped + shells.damped) / np.where(mass > 0, mass, 1.0)
    short = min(made.step_limit, shells.step_limit)
    movable = _movable(system, numbers, v)
    obstacles = tuple(contact.obstacle for contact in system.rigid_contacts)
    hanging = [hung for tie in system.ties if (hung := _hung(system, tie, numbers, x)) is not None]
    hanging += [
        Hanging(skin.part, skin.nodes, skin.corners[:, None], np.ones((len(skin.nodes), 1))) for skin in skins
    ]
    _check_hung_once(hanging, x)
    _check_not_held(system, hanging, numbers)
    frames, frame_arrays, frame_states, frame_obstacles, penalties = {}, [], [], [], {}
    for part in system.bodies:
        name = part.body.name
        if part.body.kind != "explicit":
            own = [each for each in hanging if each.part == name]
            frame, arrays, state, touched, pressed = _frame(system, part, own, mass, x)
            frames[name] = frame
            frame_arrays.append(arrays)
            frame_states.append(state)
            frame_obstacles.append(touched)
            penalties[name] = pressed
    surfaces, contact_rate, between = touching_surfaces(
        system, numbers, skins, hanging, frames, mass, x, short
    )
    pressed = {}
    for place, (name, frame) in enumerate(frames.items()):
        both = [each for each in (penalties[name], between.get(name)) if each is not None]
        pressed[name] = sum(both[1:], both[0]) if both else None
        limit = jnp.asarray(frame.step_limit(pressed[name]))
        frame_arrays[place] = frame_arrays[place]._replace(step_limit=limit)
    floating = _floating(system, tuple(frames))
    machine, change = None, None
    if floating is not None:
        machine, change, frame_states = _joined_start(floating, frames, frame_states, time)
    joined = joined_frames(
        system, method.scheme, frames, tuple(frame_arrays), tuple(frame_states), pressed, machine, time
    )
    for place in joined.limited:
        frame_arrays[place] = frame_arrays[place]._replace(step_limit=jnp.asarray(joined.step_limit))
    elements = [load for load in system.loads if isinstance(load, ForceElement)]
    stores = () if joined.machine is None else storing_elements(joined.machine, elements)
    touching, obstacle_of, on_obstacles = [], [], 0.0
    for number, contact in enumerate(system.rigid_contacts):
        if contact.nodes.body in numbers:
            nodes = numbers[contact.nodes.body][system.node_numbers(contact.nodes)]
            stiffness = _stiffness(contact, mass[nodes], short)
            on_obstacles = max(on_obstacles, float((stiffness / mass[nodes]).max()))
            _check_outside(contact, x[nodes])
            touching.append(NodesTouching(jnp.asarray(nodes), jnp.asarray(stiffness)))
            obstacle_of.append(number)
    model = MarchModel(
        tuple(made.blocks),
        tuple(made.limits),
        tuple(made.betas),
        jnp.asarray(mass),
        jnp.asarray(alpha),
        jnp.asarray(movable),
        tuple(frame_arrays),
        joined.ties,
        tuple(touching),
        surfaces,
        _loaded(system, numbers),
        jnp.asarray([obstacle.mass for obstacle in obstacles], dtype=float),
        jnp.asarray(system.gravity),
        jnp.asarray(contact_rate + on_obstacles),
        tuple(shells.blocks),
        shells.spins(system.supports, numbers, system),
        jnp.asarray(shells.step_limit),
        tuple(load.law for load in system.loads if isinstance(load, BaseAcceleration)),
        joined.machine,
        jnp.asarray(joined.driven),
    )
    methods = Methods(
        tuple(made.laws),
        tuple(made.deletions),
        tuple(shells.laws),
        tuple(shells.deletions),
        obstacles,
        tuple(obstacle_of),
        tuple(frame_obstacles),
        joined.tied,
        joined.numbers,
        stores,
        method,
    )
    for arrays, state in zip(frame_arrays, frame_states, strict=True):
        if state.y.any() or system.joints:  # deformed, or moved by joints, at the start
            x[np.asarray(arrays.nodes)] = hung_places(arrays, state).T
    start = _start(model, methods, x, v, tuple(frame_states), shells.start())
    if system.controllers:
        assert floating is not None  # controllers were checked to act on frames
        assert joined.machine is not None
        now = frame_motion(joined.machine, model.frames, start.frames, jnp.asarray(time))
        control = first_control(floating, joined.machine, jax.tree.map(np.asarray, now))
        start = start._replace(control=jax.tree.map(jnp.asarray, control))
    if any(stores):
        own = joined.machine, elements, stores, model.frames, start.frames, jnp.asarray(time)
        internal = start.energies.internal + stored_energy(*own)
        start = start._replace(energies=start.energies._replace(internal=internal))
    start = with_forces(model, methods, start._replace(time=jnp.asarray(time)))
    return Built(model, methods, start, numbers, made.spans, shells.spans, frames, floating, change)


def _floating(system: System, names: Sequence[str]) -> System | None:
    """The bodies on frames alone, with what joins them and acts on them; None without any."""

    def acts(load: Any) -> bool:
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
    """The frames as floating bodies without redundant joints, and their states, which fit the joints."""
    model, change = build_model(floating), None
    if floating.joints:
        start = consistent_start(CompiledMachine(floating, model), time)
        model, change = start.machine.model, start.change
        states = [
            placed_state(frame, *place, start.velocity[part])
            for frame, place, part in zip(
                frames.values(),
                _places(model, start.configuration),
                model.slices,
                strict=True,
            )
        ]
    return replace(model, groups=()), change, states


def _places(model: Model, where: Configuration) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    for number, part in enumerate(model.coordinate_slices):
        yield where.origins[number], where.rotations[number], where.coordinates[part]


def _movable(system: System, numbers: dict[str, IntArray], v: FloatArray) -> FloatArray:
    """(3, N) 1, or 0 where nodes are held, which begin at rest."""
    movable = np.ones((3, len(v)))
    for support in system.supports:
        held = numbers[support.nodes.body][system.node_numbers(support.nodes)]
        for axis in (axis for axis in support.axes if axis < 3):
            movable[axis, held] = 0.0
            v[held, axis] = 0.0
    return movable


def _loaded(system: System, numbers: dict[str, IntArray]) -> tuple[Any, ...]:
    """Nodes, number of those that share it, and law of each load on explicit nodes."""
    found = []
    for load in system.loads:
        if isinstance(load, DeadForce) and load.body in numbers:
            own, shared = _loaded_nodes(system, load)
            found.append((jnp.asarray(numbers[load.body][own]), shared, load.law))
    return tuple(found)


def _loaded_nodes(system: System, load: DeadForce) -> tuple[IntArray, float]:
    """Numbers of the nodes of a load within its part, and how many of them share its force."""
    if not isinstance(load.at, str):
        return load.nodes, 1.0
    nodes = system.node_numbers(At(load.body, load.at))
    return nodes, float(len(nodes))


def _start(
    model: MarchModel,
    methods: Methods,
    x: FloatArray,
    v: FloatArray,
    frames: tuple[FrameState, ...],
    turning: Turning,
) -> MarchState:
    zero = jnp.zeros(())
    held = [0.5 * at.y @ own.model.stiffness @ at.y for own, at in zip(model.frames, frames, strict=True)]
    return MarchState(
        time=zero,
        before=zero,
        frame_before=zero,
        x=jnp.asarray(x.T),
        v=jnp.asarray(v.T),
        forces=jnp.zeros((4, 3, len(x))),
        materials=tuple(
            law.initial(block.volumes.shape) for law, block in zip(methods.laws, model.blocks, strict=True)
        ),
        ratios=tuple(jnp.ones(block.volumes.shape) for block in model.blocks),
        alive=tuple(jnp.ones(block.volumes.shape[1]) for block in model.blocks),
        layers=tuple(None if shell.layers is None else rest_layers(shell) for shell in model.shells),
        shells_alive=tuple(jnp.ones(shell.nodes.shape[1]) for shell in model.shells),
        frames=frames,
        obstacles=tuple(
            ObstacleState(jnp.zeros(3), jnp.asarray(obstacle.velocity, dtype=float))
            for obstacle in methods.obstacles
        ),
        turning=turning,
        obstacle_forces=jnp.zeros((len(methods.obstacles), 3)),
        energies=Energies(*(zero for _ in Energies._fields))._replace(internal=sum(held, zero)),
        initial=zero,
        ratio_bound=jnp.asarray(methods.explicit.largest_ratio),
        ratio_wait=jnp.asarray(0),
        ratio_patience=jnp.asarray(1),
        smallest=jnp.ones(()),
        steps=jnp.asarray(0),
        control=None,
    )


def _numbered(system: System, explicit: list[Placed]) -> tuple[dict[str, IntArray], FloatArray, FloatArray]:
    """Numbers of the nodes of each explicit part, those that are tied in common; positions and velocities."""
    numbers: dict[str, IntArray] = {}
    x, v = np.empty((0, 3)), np.empty((0, 3))
    for part in explicit:
        name, nodes = part.body.name, undeformed(part)
        own = np.full(len(nodes), -1)
        for tie in system.ties:
            if tie.nodes.body == name and tie.on in numbers:
                shared = system.node_numbers(tie.nodes)
                other = numbers[tie.on]
                own[shared] = _met(tie, nodes[shared], x[other], other)
            elif tie.on == name and tie.nodes.body in numbers:
                shared = numbers[tie.nodes.body][system.node_numbers(tie.nodes)]
                met = _met(tie, x[shared], nodes, np.arange(len(nodes)))
                own[met] = shared
        fresh = own < 0
        own[fresh] = len(x) + np.arange(fresh.sum())
        numbers[name] = own
        x = np.vstack([x, nodes[fresh]])
        rates = part.body.expand(part.coordinate_rates) @ part.rotation.T
        v = np.vstack([v, (rigid_velocities(part, nodes) + rates)[fresh]])
    return numbers, x, v


def _met(tie: Tie, points: FloatArray, nodes: FloatArray, numbers: IntArray) -> IntArray:
    found = meeting_nodes(points, nodes, within(tie, points))
    if (found < 0).any():
        lost = points[found < 0][0]
        raise ModelError(
            f"tie of '{tie.nodes}' on '{tie.on}': the node at {np.array2string(lost, precision=6)} "
            f"meets no node "
            "of the other part; explicit parts are tied node to node: give them a common mesh there"
        )
    return numbers[found]


def _hung(system: System, tie: Tie, numbers: dict[str, IntArray], x: FloatArray) -> Hanging | None:
    """The explicit nodes of a tie on a modal part; None of other ties."""
    if tie.on in numbers or tie.nodes.body not in numbers:
        return None
    nodes = numbers[tie.nodes.body][system.node_numbers(tie.nodes)]
    corners, weights = met_material(system, tie, x[nodes])
    return Hanging(tie.on, nodes, corners, weights)


def _check_hung_once(hanging: list[Hanging], x: FloatArray) -> None:
    """An explicit node on two frames would give both its mass, and stand where the last one puts it."""
    nodes = np.concatenate([each.nodes for each in hanging] or [np.empty(0, dtype=np.int64)])
    found, counts = np.unique(nodes, return_counts=True)
    if (counts > 1).any():
        at = np.array2string(x[found[counts > 1][0]], precision=6)
        on = " and ".join(f"'{each.part}'" for each in hanging if found[counts > 1][0] in each.nodes)
        raise ModelError(
            f"the explicit node at {at} is tied on {on}: a node hangs on one modal part, once; tie the modal "
            "parts to each other, and leave the node out of one of the sets"
        )


def _check_not_held(system: System, hanging: list[Hanging], numbers: dict[str, IntArray]) -> None:
    """A support of nodes that a modal part leads would have no effect."""
    for support in system.supports:
        held = numbers[support.nodes.body][system.node_numbers(support.nodes)]
        for each in hanging:
            if min(support.axes, default=3) < 3 and np.isin(each.nodes, held).any():
                raise ModelError(
                    f"support of '{support.nodes}': some of its nodes are tied on '{each.part}', which leads "
                    "them; leave these out of the support"
                )


def _frame(
    system: System, part: Placed, hanging: list[Hanging], mass: FloatArray, x: FloatArray
) -> tuple[ModalFrame, FrameArrays, FrameState, tuple[int, ...], FloatArray | None]:
    body: Any = RigidFrame(part.body) if isinstance(part.body, RigidBody) else part.body
    nodes = np.concatenate([each.nodes for each in hanging] or [np.empty(0, dtype=np.int64)])
    local = (x[nodes] - part.position) @ part.rotation
    shapes = np.concatenate(
        [np.einsum("nc,ncik->nik", each.weights, body.shapes[each.corners]) for each in hanging]
        or [np.empty((0, 3, body.n_modes))]
    )
    frame = modal_frame(body, local, shapes, mass[nodes])
    touching, touched, stiffest = [], [], None
    for number, contact in enumerate(system.rigid_contacts):
        if contact.nodes.body == body.name:
            own = system.node_numbers(contact.nodes)
            stiffness = _modal_stiffness(contact, frame, own)
            _check_outside(contact, undeformed(part)[own])
            touching.append(
                NodesTouching(
                    jnp.asarray(own),
                    jnp.asarray(stiffness),
                    jnp.asarray(frame.weights(own)),
                    jnp.asarray(frame.shapes[own]),
                )
            )
            touched.append(number)
            added = frame.penalty_stiffness(own, stiffness)
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
        jnp.asarray(jnp.inf),  # once all contacts are known
        None if frame.spin_bound is None else jnp.asarray(frame.spin_bound),
    )
    rates = np.concatenate([part.twist, part.coordinate_rates])
    start = placed_state(frame, part.position, part.rotation, part.coordinates, rates)
    return frame, arrays, start, tuple(touched), stiffest


def _stiffness(contact: Contact, masses: FloatArray, short: float) -> FloatArray:
    if contact.stiffness is not None:
        return np.full(len(masses), contact.stiffness)
    return contact.fraction * masses * (2 / short) ** 2


def _modal_stiffness(contact: Contact, frame: ModalFrame, nodes: IntArray) -> FloatArray:
    if contact.stiffness is not None:
        return np.full(len(nodes), contact.stiffness)
    return frame.stiffness_at(nodes, contact.fraction)


def _check_outside(contact: Contact, points: FloatArray) -> None:
    gap = np.asarray(contact.obstacle.gap(jnp.asarray(points.T))[0])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if gap.min() < -1e-6 * size:
        worst = int(gap.argmin())
        raise ModelError(
            f"contact of '{contact.nodes}': the node at {np.array2string(points[worst], precision=6)} begins "
            f"{-gap[worst]:.3g} inside the {type(contact.obstacle).__name__}; move the parts apart"
        )

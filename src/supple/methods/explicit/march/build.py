"""Arrays of the explicit time integration of a system: shared nodes, mass tied to frames, contacts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from supple.arrays import FloatArray, IntArray
from supple.equations.nodal_load import PreparedLoad, prepared
from supple.errors import ModelError
from supple.machine import At, BaseAcceleration, DeadForce, FollowerPressure, Placed, System, Tie
from supple.machine.laws.time_law import TimeLaw
from supple.machine.obstacles import Obstacle
from supple.machine.ties.meeting import meeting_nodes
from supple.methods.explicit.march.build_blocks import explicit_blocks
from supple.methods.explicit.march.build_frames import Framed, build_frames
from supple.methods.explicit.march.build_obstacles import check_outside, recoil
from supple.methods.explicit.march.build_surfaces import MarchNodes, TiedNodes, modal_skins
from supple.methods.explicit.march.build_ties import (
    ROUNDED,
    check_positions,
    check_velocities,
    largest_distance,
    met_material,
)
from supple.methods.explicit.march.frame_step import tied_positions, tied_velocities
from supple.methods.explicit.march.march_model import (
    Energies,
    MarchModel,
    MarchState,
    Methods,
    NodesTouching,
    ObstacleState,
)
from supple.methods.explicit.march.march_step import begun
from supple.methods.explicit.march.turning_nodes import TriadState
from supple.methods.explicit.method import Explicit
from supple.methods.explicit.modal_frame import ModalFrame
from supple.methods.explicit.start_motion import rigid_velocities, undeformed


@dataclass(frozen=True, eq=False)
class Built:
    """A system prepared for time integration.

    nodes : numbers in the model of the nodes of each explicit part, by its name
    blocks : slice of the model's blocks for each explicit part, by its name
    framed : modal parts and rigid bodies
    """

    model: MarchModel
    methods: Methods
    start: MarchState
    nodes: dict[str, IntArray]
    blocks: dict[str, slice]
    framed: Framed

    @property
    def frames(self) -> dict[str, ModalFrame]:
        """Modal parts and rigid bodies, in the order of the model, with their integrated modes."""
        return self.framed.frames


def built(system: System, method: Explicit, time: float = 0.0) -> Built:
    """Prepare a system for time integration from a time.

    Raises ModelError for ties whose nodes do not match or start at other velocities, nodes tied to two modal
    parts, supports of nodes tied to one, nodes that start inside an obstacle or a surface, and open joints.
    """
    explicit = [placed for placed in system.bodies if placed.body.kind == "explicit"]
    numbers, x, v = _numbered(system, explicit)
    skins = modal_skins(system, len(x))
    for skin in skins:
        part = system.placed(skin.part)
        corners = undeformed(part)[skin.corners[:, 0]]
        x = np.vstack([x, corners])
        v = np.vstack([v, rigid_velocities(part, corners)])
    made = explicit_blocks(explicit, numbers, len(x))
    mass, short = made.mass, made.step_limit
    alpha = made.damped / np.where(mass > 0, mass, 1.0)
    movable = _movable(system, numbers, v)
    obstacles = tuple(contact.obstacle for contact in system.rigid_contacts)
    ties = [tie for tie in system.ties if tie.nodes.body in numbers and tie.on not in numbers]
    tied = [_tied(system, tie, numbers, x) for tie in ties] + skins
    _check_tied_once(tied, x)
    _check_not_held(system, tied, numbers)
    touching, pressed, of_obstacles = _touching(system, numbers, x, mass, short)
    framed = build_frames(system, method, MarchNodes(numbers, x, mass, skins, tied, short, pressed), time)
    model = MarchModel(
        tuple(made.blocks),
        jnp.asarray(mass),
        jnp.asarray(alpha),
        jnp.asarray(movable),
        framed.arrays,
        framed.joined.ties,
        touching,
        framed.surfaces,
        tuple(_loaded(system, numbers)),
        _pressed(system, numbers),
        jnp.asarray([obstacle.mass for obstacle in obstacles], dtype=float),
        jnp.asarray(system.gravity),
        jnp.asarray(max(framed.contact_rate, of_obstacles)),
        made.spins(numbers, system),
        tuple(load.law for load in system.loads if isinstance(load, BaseAcceleration)),
        framed.joined.machine,
        jnp.asarray(framed.joined.driven),
    )
    methods = Methods(framed.joined.tied, framed.joined.numbers, framed.stores, method)
    led, rates = x.copy(), v.copy()
    for arrays, state in zip(framed.arrays, framed.states, strict=True):
        led[np.asarray(arrays.nodes)] = tied_positions(arrays, state).T
        rates[np.asarray(arrays.nodes)] = tied_velocities(arrays, state).T
    for tie, own in zip(ties, tied, strict=False):
        apart = np.linalg.norm(led[own.nodes] - x[own.nodes], axis=1).max()
        check_positions(tie, float(apart), largest_distance(system, tie))
        check_velocities(tie, v[own.nodes], rates[own.nodes], ROUNDED)
    for arrays, state in zip(framed.arrays, framed.states, strict=True):
        if state.y.any() or state.vy.any() or system.joints:  # deformed, or moved by joints, at the start
            own = np.asarray(arrays.nodes)
            x[own], v[own] = led[own], rates[own]
    start = _start(model, method, x, v, framed, obstacles, made.triads())
    start = begun(model, start._replace(time=jnp.asarray(time)))
    return Built(model, methods, start, numbers, made.spans, framed)


def _movable(system: System, numbers: dict[str, IntArray], v: FloatArray) -> FloatArray:
    """(3, N) 1, or 0 for fixed components; the velocities v of fixed components are set to zero."""
    movable = np.ones((3, len(v)))
    for support in system.supports:
        held = numbers[support.nodes.body][system.node_numbers(support.nodes)]
        for axis in (axis for axis in support.axes if axis < 3):
            movable[axis, held] = 0.0
            v[held, axis] = 0.0
    return movable


def _loaded(system: System, numbers: dict[str, IntArray]) -> Iterator[tuple[jax.Array, float, TimeLaw]]:
    """Nodes, number of nodes that share the force, and law of each load on explicit nodes."""
    for load in system.loads:
        if isinstance(load, DeadForce) and load.body in numbers:
            own, shared = load.nodes, 1
            if isinstance(load.at, str):
                own = system.node_numbers(At(load.body, load.at))
                shared = len(own)
            yield jnp.asarray(numbers[load.body][own]), float(shared), load.law


def _pressed(system: System, numbers: dict[str, IntArray]) -> tuple[tuple[jax.Array, PreparedLoad], ...]:
    """Nodes and arrays of each pressure on faces of explicit elements."""
    return tuple(
        (jnp.asarray(numbers[load.body][load.nodes]), prepared(load))
        for load in system.loads
        if isinstance(load, FollowerPressure) and load.body in numbers
    )


def _start(
    model: MarchModel,
    method: Explicit,
    x: FloatArray,
    v: FloatArray,
    framed: Framed,
    obstacles: tuple[Obstacle, ...],
    turning: TriadState,
) -> MarchState:
    zero, frames = jnp.zeros(()), framed.states
    held = [0.5 * at.y @ own.model.stiffness @ at.y for own, at in zip(model.frames, frames, strict=True)]
    return MarchState(
        time=zero,
        before=zero,
        frame_before=zero,
        x=jnp.asarray(x.T),
        v=jnp.asarray(v.T),
        forces=jnp.zeros((4, 3, len(x))),
        blocks=tuple(block.start() for block in model.blocks),
        frames=frames,
        obstacles=tuple(
            ObstacleState(jnp.zeros(3), jnp.asarray(obstacle.velocity, dtype=float)) for obstacle in obstacles
        ),
        turning=turning,
        largest=zero,
        obstacle_forces=jnp.zeros((len(obstacles), 3)),
        energies=Energies(*(zero for _ in Energies._fields))._replace(internal=sum(held, framed.stored)),
        initial=zero,
        ratio_bound=jnp.asarray(method.largest_ratio),
        ratio_wait=jnp.asarray(0),
        ratio_patience=jnp.asarray(1),
        smallest=jnp.ones(()),
        steps=jnp.asarray(0),
        control=framed.control,
    )


def _numbered(system: System, explicit: list[Placed]) -> tuple[dict[str, IntArray], FloatArray, FloatArray]:
    """Node numbers of each explicit part, shared by tied nodes; positions and velocities of all nodes."""
    nodes = {part.body.name: undeformed(part) for part in explicit}
    rates = {
        part.body.name: rigid_velocities(part, nodes[part.body.name])
        + part.body.expand(part.coordinate_rates) @ part.rotation.T
        for part in explicit
    }
    first = dict(zip(nodes, np.cumsum([0, *map(len, nodes.values())]), strict=False))
    joined = [np.empty((2, 0), dtype=np.int64)]
    for tie in system.ties:
        if tie.nodes.body in nodes and tie.on in nodes:
            own = system.node_numbers(tie.nodes)
            met = _met(system, tie, nodes[tie.nodes.body][own], nodes[tie.on])
            check_velocities(tie, rates[tie.nodes.body][own], rates[tie.on][met], ROUNDED)
            joined.append(np.array([first[tie.nodes.body] + own, first[tie.on] + met]))
    x, v = (np.concatenate([np.empty((0, 3)), *each.values()]) for each in (nodes, rates))
    one, two = np.concatenate(joined, axis=1)
    links = sparse.coo_array((np.ones(len(one)), (one, two)), shape=(len(x), len(x)))
    group = connected_components(links, directed=False)[1] if len(one) else np.arange(len(x))
    # Numbers in the order of the parts: a joined node is that of its first part.
    _, lowest, place = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(lowest)
    of_node = np.argsort(order)[place]
    numbers = {name: of_node[first[name] : first[name] + len(own)] for name, own in nodes.items()}
    return numbers, x[lowest[order]], v[lowest[order]]


def _met(system: System, tie: Tie, points: FloatArray, nodes: FloatArray) -> IntArray:
    """Numbers of the nodes of the other part at points (n, 3); ModelError where there is none."""
    found = meeting_nodes(points, nodes, largest_distance(system, tie))
    if (found < 0).any():
        lost = points[found < 0][0]
        raise ModelError(
            f"tie of '{tie.nodes}' on '{tie.on}': the node at {np.array2string(lost, precision=6)} matches "
            "no node of the other part; explicit parts are tied node to node: use matching meshes there"
        )
    return found


def _tied(system: System, tie: Tie, numbers: dict[str, IntArray], x: FloatArray) -> TiedNodes:
    """The explicit nodes of a tie to a modal part."""
    nodes = numbers[tie.nodes.body][system.node_numbers(tie.nodes)]
    corners, weights = met_material(system, tie, x[nodes])
    return TiedNodes(tie.on, nodes, corners, weights)


def _check_tied_once(tied: list[TiedNodes], x: FloatArray) -> None:
    """Raise ModelError for an explicit node tied twice: two frames would include its mass."""
    nodes = np.concatenate([each.nodes for each in tied] or [np.empty(0, dtype=np.int64)])
    found, counts = np.unique(nodes, return_counts=True)
    if (counts > 1).any():
        at = np.array2string(x[found[counts > 1][0]], precision=6)
        on = " and ".join(f"'{each.part}'" for each in tied if found[counts > 1][0] in each.nodes)
        raise ModelError(
            f"the explicit node at {at} is tied to {on}: a node can be tied to one modal part, once; tie the "
            "modal parts to each other, and leave the node out of one of the sets"
        )


def _check_not_held(system: System, tied: list[TiedNodes], numbers: dict[str, IntArray]) -> None:
    """Raise ModelError for a support of nodes tied to a modal part, which would have no effect."""
    for support in system.supports:
        held = numbers[support.nodes.body][system.node_numbers(support.nodes)]
        for each in tied:
            if min(support.axes, default=3) < 3 and np.isin(each.nodes, held).any():
                raise ModelError(
                    f"support of '{support.nodes}': some of its nodes are tied to '{each.part}', which moves "
                    "them; omit these nodes from the support"
                )


def _touching(
    system: System, numbers: dict[str, IntArray], x: FloatArray, mass: FloatArray, short: float
) -> tuple[tuple[NodesTouching, ...], FloatArray, float]:
    """Explicit nodes in contact, and the effect of their contacts on the step limits with all of them closed.

    Returns the nodes; the stiffness at each node (N,), N/m, with the share of free obstacles; and the largest
    squared frequency of a free obstacle, 1/s^2.
    """
    touching, pressed, largest = [], np.zeros(len(x)), 0.0
    for number, contact in enumerate(system.rigid_contacts):
        if contact.nodes.body in numbers:
            every = numbers[contact.nodes.body]
            nodes = every[system.node_numbers(contact.nodes)]
            stiffness = contact.fraction * mass[nodes] * (2 / short) ** 2
            if contact.stiffness is not None:
                stiffness = np.full(len(nodes), contact.stiffness)
            check_outside(contact, x[nodes], x[every])
            arrays = jnp.asarray(nodes), jnp.asarray(stiffness), jnp.zeros((0, 4)), jnp.zeros((0, 3, 0))
            touching.append(NodesTouching(*arrays, number, contact.obstacle))
            rate = float((stiffness / mass[nodes]).max())
            with_obstacle = rate + recoil(contact.obstacle, x[nodes], stiffness)
            np.add.at(pressed, nodes, stiffness * (with_obstacle / rate))
            largest = max(largest, with_obstacle)
    return tuple(touching), pressed, largest

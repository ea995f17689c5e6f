"""Machine of intrinsic, rigid and reduced bodies with any joints, as arrays for compiled code.

Joints and forces act on an intrinsic body at its stations. The equations of joints and forces are those of
floating frames, where each such station is a massless rigid body. Forces on a station act on the amplitudes
of the line through the velocities of the station.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.body import RigidBody
from supple.equations.build_model import station_model
from supple.equations.configuration import Configuration
from supple.equations.machine_model import Model
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    Controller,
    EndReading,
    ForceElement,
    Joint,
    JointFriction,
    NodalLoad,
    Placed,
    SampledController,
    System,
)
from supple.methods.intrinsic.equal_lines import EqualLines, for_each_line
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.line_model import LineModel, LineState
from supple.methods.intrinsic.line_system import LineSystem, RootDrive, States
from supple.methods.intrinsic.machine_of_lines import line_start, machine_of_lines
from supple.methods.intrinsic.station_loads import StationLoad, machine_loads
from supple.methods.intrinsic.strain_integration import StationPlaces, rotation_of, station_places

STATIC = {"static": True}
E = TypeVar("E", bound=Joint | ForceElement)
C = TypeVar("C", bound=Controller | SampledController)


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class JoinedArrays:
    """Arrays of the machine.

    lines : equations of the intrinsic bodies
    drives : prescribed motions of the roots of these bodies, or None
    loads : loads on the stations, including force elements if only ground joints support the lines
    model : floating bodies, joints and forces; the coupled stations are massless bodies
    coupled : numbers of the coupled stations, line by line
    """

    lines: EqualLines
    drives: tuple[RootDrive | None, ...]
    loads: tuple[StationLoad, ...]
    model: Model
    coupled: tuple[tuple[int, ...], ...] = field(metadata=STATIC)

    @property
    def n_coupled(self) -> int:
        """Number of stations coupled to joints or forces."""
        return sum(map(len, self.coupled))

    @property
    def n_bodies(self) -> int:
        """Number of floating bodies, which are first in the model."""
        return len(self.model.sizes) - self.n_coupled

    @property
    def n_floating(self) -> int:
        """Number of velocities of the floating bodies."""
        return self.model.n_velocities - 6 * self.n_coupled

    @property
    def line_system(self) -> LineSystem:
        """The lines with their drives and loads."""
        return LineSystem(self.lines, self.drives, self.loads)


class JoinedMachine(NamedTuple):
    """A prepared machine.

    seen : System       floating bodies, and a body for every coupled station
    lines : the placed intrinsic bodies
    states : initial states of the lines, as placed
    """

    system: System
    seen: System
    lines: tuple[Placed, ...]
    arrays: JoinedArrays
    states: States

    @property
    def others(self) -> tuple[Placed, ...]:
        """The placed bodies that are not intrinsic, in the order of the model."""
        return tuple(placed for placed in self.system.bodies if placed not in self.lines)


class LinesAsStations(NamedTuple):
    """A machine whose coupled stations are bodies, for the equations of its joints and forces.

    seen : System       floating bodies, and a body for every coupled station
    lines : the placed intrinsic bodies
    coupled : numbers of the coupled stations, line by line
    on_lines : System   the lines with the loads on their stations
    """

    seen: System
    lines: tuple[Placed, ...]
    coupled: tuple[tuple[int, ...], ...]
    on_lines: System


def lines_as_stations(system: System, also: Sequence[At] = ()) -> LinesAsStations:
    """The system with a body for each station coupled to joints, forces and controllers.

    also : further ends to include
    Raises ModelError for intrinsic bodies with a supported root.
    """
    lines = tuple(placed for placed in system.bodies if isinstance(placed.body, IntrinsicBody))
    others = tuple(placed for placed in system.bodies if placed not in lines)
    for placed in lines:
        if body_of(placed).support.free.shape[1] < 6:
            raise ModelError(
                f"intrinsic body '{placed.body.name}': its modes belong to a supported root, but joints "
                "act on it: place released(body), which also has rigid motion"
            )
    forces = [load for load in system.loads if isinstance(load, ForceElement)]
    ends = [*_ends(system, forces), *also]
    coupled = tuple(
        tuple(sorted({_number(placed, end) for end in ends if end.body == placed.body.name}))
        for placed in lines
    )
    joints = {joint.name: seen_element(system, joint) for joint in system.joints}
    bases = [load for load in system.loads if isinstance(load, BaseAcceleration)]
    nodal = [load for load in system.loads if isinstance(load, NodalLoad)]
    names = {placed.body.name for placed in lines}
    seen = System(
        [*others, *(_station(p, n) for p, own in zip(lines, coupled, strict=True) for n in own)],
        list(joints.values()),
        [
            *(
                replace(load, joint=joints[load.joint.name])
                if isinstance(load, JointFriction)
                else seen_element(system, load)
                for load in forces
            ),
            *(load for load in nodal if load.body not in names),
            *bases,
        ],
        gravity=system.gravity,
        controllers=[_seen_controller(system, controller) for controller in system.controllers],
    )
    own_loads = [load for load in nodal if load.body in names]
    return LinesAsStations(
        seen, lines, coupled, System(lines, loads=[*own_loads, *bases], gravity=system.gravity)
    )


def joined_machine(system: System, time: float, also: Sequence[At] = ()) -> JoinedMachine:
    """Arrays of a machine; ModelError as `lines_as_stations` and `machine_loads`.

    also : as for `lines_as_stations`
    """
    seen, lines, coupled, on_lines = lines_as_stations(system, also)
    arrays = JoinedArrays(
        lines=EqualLines.of([body_of(placed).model for placed in lines]),
        drives=(None,) * len(lines),
        loads=machine_loads(on_lines),
        model=station_model(seen, len(seen.bodies) - sum(map(len, coupled)), None),
        coupled=coupled,
    )
    return JoinedMachine(
        system, seen, lines, arrays, tuple(line_start(placed, None, time) for placed in lines)
    )


def supported_machine(system: System, time: float) -> JoinedMachine:
    """Arrays of a machine of intrinsic bodies whose roots are supported by ground joints alone.

    The modes and drives of the lines include the joints; their loads include the forces. One station is
    coupled only because a model needs at least one body.
    """
    made = machine_of_lines(system, time)
    first, *others = system.bodies
    seen = System([_station(first, 0)])
    arrays = JoinedArrays(
        lines=EqualLines.of(made.lines.lines),
        drives=made.lines.drives,
        loads=made.lines.loads,
        model=station_model(seen, 0, None),
        coupled=((0,), *((),) * len(others)),
    )
    return JoinedMachine(system, seen, tuple(system.bodies), arrays, made.start)


def _ends(system: System, forces: list[ForceElement]) -> list[At]:
    """Ends of joints, forces and controllers, both actuators and sensors."""
    elements: list[Joint | ForceElement] = [*system.joints, *forces]
    read = []
    for controller in system.controllers:
        elements += controller.drives.values()
        read += [each.at for each in controller.reads.values() if isinstance(each, EndReading)]
    return read + [end for element in elements for end in (element.first, element.second)]


def _number(placed: Placed, end: At) -> int:
    return body_of(placed).interface(end.interface).number


def _label(placed: Placed, number: int) -> str:
    return f"{placed.body.name}, station {number}"


def _station(placed: Placed, number: int) -> Placed:
    """A rigid body at the position of a station in the undeformed body."""
    position, rotation = placed.assembly
    point = position + rotation @ body_of(placed).line.tree.points[number]
    body = RigidBody(_label(placed, number), 1.0, np.zeros(3), np.eye(3), {"station": np.zeros(3)})
    return Placed(body, point, rotation)


def seen_element(system: System, element: E) -> E:
    """The joint or force with its ends on floating bodies and on bodies of stations."""
    return replace(element, first=seen_end(system, element.first), second=seen_end(system, element.second))


def seen_end(system: System, end: At) -> At:
    """The end itself, or, on an intrinsic body, the end on the body of its station."""
    if end == GROUND:
        return end
    placed = system.bodies[system.body_index(end.body)]
    if not isinstance(placed.body, IntrinsicBody):
        return end
    return At(_label(placed, _number(placed, end)), "station")


def _seen_controller(system: System, controller: C) -> C:
    """The controller with its ends on floating bodies and on bodies of stations."""
    reads = {
        name: EndReading(seen_end(system, each.at)) if isinstance(each, EndReading) else each
        for name, each in controller.reads.items()
    }
    drives = {name: seen_element(system, element) for name, element in controller.drives.items()}
    return replace(controller, reads=reads, drives=drives)


def coupled_places(arrays: JoinedArrays, states: States) -> tuple[jax.Array, jax.Array]:
    """Positions (s, 3) and rotations (s, 3, 3) of the coupled stations, from the strains."""
    places = for_each_line(_coupled_places, arrays.lines, states, tuple(map(_Stations, arrays.coupled)))
    return (
        jnp.concatenate([jnp.zeros((0, 3)), *(own.positions for own in places)]),
        jnp.concatenate([jnp.zeros((0, 3, 3)), *(own.rotations for own in places)]),
    )


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class _Stations:
    """Numbers of the coupled stations of one line, part of the structure of a program."""

    numbers: tuple[int, ...] = field(metadata=STATIC)


def _coupled_places(model: LineModel, state: LineState, coupled: _Stations) -> StationPlaces:
    """Places of the coupled stations of one line."""
    root = rotation_of(state.quaternion)
    if not any(coupled.numbers):  # at most the root: no strains to integrate
        n = len(coupled.numbers)
        return StationPlaces(jnp.broadcast_to(root, (n, 3, 3)), jnp.broadcast_to(state.position, (n, 3)))
    places = station_places(model, state.q2, root, state.position)
    chosen = np.array(coupled.numbers)
    return StationPlaces(places.rotations[chosen], places.positions[chosen])


def with_stations(arrays: JoinedArrays, floating: Configuration, states: States) -> Configuration:
    """Configuration of all bodies of the model: floating ones as given, stations from the strains."""
    n = arrays.n_bodies
    positions, rotations = coupled_places(arrays, states)
    return Configuration(
        jnp.concatenate([floating.origins[:n], positions]),
        jnp.concatenate([floating.rotations[:n], rotations]),
        floating.coordinates,
    )

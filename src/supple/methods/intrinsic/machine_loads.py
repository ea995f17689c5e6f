"""Loads of a machine as loads on the stations of its lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from supple.equations.build_model import check_apart, initial_points
from supple.errors import ModelError
from supple.machine import (
    GROUND,
    At,
    BaseAcceleration,
    DeadForce,
    FollowerForce,
    FollowerTorque,
    ForceElement,
    NodalLoad,
    Placed,
    System,
)
from supple.methods.intrinsic.intrinsic_body import IntrinsicBody, body_of
from supple.methods.intrinsic.station_loads import (
    End,
    Follower,
    Gravity,
    SpreadLoad,
    StationElement,
    StationLoad,
)
from supple.value_content import fixed_function

__all__ = ["machine_loads"]


def machine_loads(system: System) -> tuple[StationLoad, ...]:
    """The loads, and gravity, of a machine of intrinsic bodies.

    Raises ModelError for two base accelerations, and for a force along a line whose ends coincide.
    """
    numbers = {placed.body.name: number for number, placed in enumerate(system.bodies)}
    bases = [load.law for load in system.loads if isinstance(load, BaseAcceleration)]
    if len(bases) > 1:
        raise ModelError(f"only one base acceleration is supported; {len(bases)} are given: add them up")
    found: list[StationLoad] = []
    if system.gravity.any() or bases:
        base = bases[0] if bases else None
        found += [
            Gravity(_translating_mass(body_of(placed)), system.gravity, base, number)
            for number, placed in enumerate(system.bodies)
        ]
    for load in system.loads:
        match load:
            case BaseAcceleration():
                pass
            case NodalLoad():
                found.append(_spread(system.bodies, numbers[load.body], load))
            case FollowerForce() | FollowerTorque() if GROUND == load.second:
                found.append(_follower(system.bodies, numbers, load))
            case ForceElement():
                found.append(_element(system, numbers, load))
    return tuple(found)


def _translating_mass(body: IntrinsicBody) -> np.ndarray:
    """Momenta of stations in unit translations: (n, 6, 3), or (6 n, 3 n) where stations share mass."""
    masses = body.line.station_masses
    if masses is not None:
        return masses[:, :, :3]
    n = body.line.n
    return body.line.mass.reshape(6 * n, n, 6)[:, :, :3].reshape(6 * n, 3 * n)


def _follower(
    bodies: Sequence[Placed], numbers: Mapping[str, int], load: FollowerForce | FollowerTorque
) -> Follower:
    line = numbers[load.first.body]
    placed = bodies[line]
    axes = np.zeros((6, 3))
    rows = slice(0, 3) if isinstance(load, FollowerForce) else slice(3, 6)
    axes[rows] = placed.assembly.rotation.T @ load.initial_axes
    return Follower(axes, load.law, body_of(placed).interface(load.first.interface).number, line)


def _element(system: System, numbers: Mapping[str, int], load: ForceElement) -> StationElement:
    check_apart(system, load)
    points = initial_points(system, load)
    element = load.assembled(*points)

    def end(own: At, point: np.ndarray) -> End:
        if own == GROUND:
            return End(element.initial_axes, point, 0, -1)
        line = numbers[own.body]
        placed = system.bodies[line]
        station = body_of(placed).interface(own.interface).number
        return End(placed.assembly.rotation.T @ element.initial_axes, np.zeros(3), station, line)

    ends = end(element.first, points[0]), end(element.second, points[1])
    return StationElement(ends, element.law, element.parameters, fixed_function(type(element).wrenches))


def _spread(bodies: Sequence[Placed], line: int, load: NodalLoad) -> SpreadLoad:
    body = body_of(bodies[line])
    if load.nodes.size:
        stations, weights = body.expansion.stations[load.nodes], body.expansion.weights[load.nodes]
        arms = body.expansion.arms(body.line.tree)[load.nodes]
    else:
        assert isinstance(load, DeadForce)
        number = body.interface(str(load.at)).number
        stations, weights, arms = np.array([[number] * 2]), np.array([[1.0, 0.0]]), np.zeros((1, 2, 3))
    return SpreadLoad(
        law=load.law,
        stations=stations,
        weights=weights,
        arms=arms,
        facets=load.facets.astype(np.int32),
        line=line,
        facet_forces=type(load).facet_forces,
        value_rank=len(load.value_shapes[0]),
    )

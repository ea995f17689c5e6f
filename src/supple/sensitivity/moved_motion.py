"""States of a run, displaced along the derivative of its motion with respect to a parameter."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from supple.equations.configuration import Configuration
from supple.equations.machine_model import Model
from supple.methods.floating.compiled.sensitivity_step import StateChange
from supple.methods.floating.compiled.state import State

_SMALL = 1e-3
"""Largest change of the motion by `small_step`: rotations in rad, positions relative to the machine's length,
deformations relative to the largest one of the body."""
_UNDEFORMED = 1e-8
"""Least reference value of a deformation, relative to the machine's length."""


def displaced_states(states: State, change: StateChange, parameter: int, step: float) -> State:
    """States (t, ..) displaced by a step of a parameter along derivatives (t, p, ..).

    Displaced rotation matrices are orthogonal: A exp(step [w]).
    """
    carried = change.carried
    of_configuration = carried.configuration

    def along(name: str) -> np.ndarray:
        return getattr(states, name) + step * getattr(carried, name)[:, parameter]

    configuration = states.configuration
    turn = _rotation_vectors(configuration.rotations, of_configuration.rotations[:, parameter])
    turned = Rotation.from_rotvec(step * turn.reshape(-1, 3)).as_matrix().reshape(*turn.shape, 3)
    return states._replace(
        configuration=Configuration(
            configuration.origins + step * of_configuration.origins[:, parameter],
            configuration.rotations @ turned,
            configuration.coordinates + step * of_configuration.coordinates[:, parameter],
        ),
        velocity=along("velocity"),
        acceleration=along("acceleration"),
        multipliers=states.multipliers + step * change.multipliers[:, parameter],
    )


def _rotation_vectors(rotations: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """`w` (.., 3) of `dA = A [w]`, in body axes; [w] is the skew matrix of w."""
    skew = np.swapaxes(rotations, -1, -2) @ changes
    skew = (skew - np.swapaxes(skew, -1, -2)) / 2
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)


def small_step(model: Model, states: State, change: StateChange, parameter: int) -> float:
    """The step of a parameter that changes the configuration by at most `_SMALL`; inf without any effect."""
    configuration, of = states.configuration, change.carried.configuration
    turn = _rotation_vectors(configuration.rotations, of.rotations[:, parameter])
    sizes = [np.abs(turn).max(), np.abs(of.origins[:, parameter]).max() / float(model.length)]
    for group in model.groups:
        if not group.r:
            continue
        places = group.coordinates.index
        scale = np.asarray(group.coordinate_scale)[:, None]
        deformed = np.abs(configuration.coordinates[:, places] / scale).max()
        change_of = np.abs(of.coordinates[:, parameter][:, places] / scale).max()
        sizes.append(change_of / max(deformed, _UNDEFORMED))
    largest = max(sizes)
    return _SMALL / largest if largest > 0 else np.inf

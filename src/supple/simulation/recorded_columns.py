"""Identification of the bodies in a result file, so that a motion is read only with its own bodies.

Signs of modes are arbitrary, and so are directions of modes with equal frequencies. Round-off decides them,
and another number of threads can change them. The coordinates of a stored motion would then have another
meaning. A few numbers identify the columns of a basis despite round-off.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import BodyForm, FullBody
from supple.errors import ModelError, ResultFileError
from supple.integrate import Solution
from supple.machine import Placed, System
from supple.methods.explicit import ModalSubdomain
from supple.methods.intrinsic import IntrinsicBody
from supple.reduction import ReducedBody
from supple.storage.result_content import COLUMNS, Metadata, ResultHeader

_ARRAYS = (
    "nodal_basis",
    "gram",
    "stiffness",
    "damping",
    "cubic",
    "quartic",
    "damping_cubic",
    "damping_quartic",
)
_OF_COORDINATES = ("nodal_basis", "mass", "frame", "shapes", "velocities", "forces")
"""Arrays that define the motion per coordinate."""

SAME = 1e-5
"""Relative tolerance of equal measures: round-off is far smaller, another sign or order far larger."""


def probe(size: int, seed: int = 0) -> NDArray[np.float64]:
    """A fixed pseudo-random vector, the same in every call."""
    return np.random.default_rng(seed).standard_normal(size)


def measures(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """Products of the columns of an array (n, ..) with a random vector."""
    return array.T @ probe(len(array))


def same_measures(then: ArrayLike, now: NDArray[np.float64]) -> bool:
    """Whether two measures belong to the same columns."""
    first = np.asarray(then)
    return first.shape == now.shape and bool(
        np.abs(first - now).max(initial=0.0) <= SAME * np.abs(first).max(initial=0.0)
    )


def columns_of(system: System) -> Metadata:
    """Metadata that identify elastic bodies."""
    measured = measured_columns(system)
    return {COLUMNS: json.dumps(measured)} if measured else {}


def measured_columns(system: System) -> dict[str, dict[str, list[float]]]:
    """Identification of each elastic body: products of its arrays with random vectors."""
    measured = {
        placed.body.name: {name: values.tolist() for name, values in _measures(placed)}
        for placed in system.bodies
    }
    return {body: measures for body, measures in measured.items() if measures}


def are_same_columns(then: Mapping[str, ArrayLike], placed: Placed) -> bool:
    """Whether the coordinates of a body have the same meaning as those of the body with measures `then`."""
    now = dict(_measures(placed))
    of_columns = [name for name in _OF_COORDINATES if name in now]
    return all(name in then and same_measures(then[name], now[name]) for name in of_columns)


def check_motions(system: System, solution: Solution) -> None:
    """Raise ModelError if the columns recorded in a solution differ from those of its body."""
    for placed in system.bodies:
        name = placed.body.name
        then = solution.columns.get(name)
        if then is not None and placed.body.n_coordinates and not are_same_columns(then, placed):
            raise ModelError(
                f"the motion of body '{name}' has other columns than the given body: a repeated reduction "
                "can change their signs. Use the body of the run (read_reduced_body of NAME-reduced.h5 "
                "beside the result)"
            )


def check_columns(header: ResultHeader, system: System, path: Path | str, *, with_start: bool = True) -> None:
    """ResultFileError if a system's elastic bodies differ from those of a result file.

    with_start : also if their initial deformation differs
    """
    for placed in system.bodies:
        then = header.columns.get(placed.body.name, {})
        for name, now in _measures(placed) if with_start else _of_body(placed.body):
            if name in then and not same_measures(then[name], now):
                raise ResultFileError(_other(path, placed, name, len(then[name])))


def _other(path: Path | str, placed: Placed, name: str, size: int) -> str:
    body = placed.body
    if name == "nodal_basis":
        return (
            f"{path} contains a motion of body '{body.name}' in {size} columns that are not those of "
            f"the given body, which has {body.n_coordinates}. A repeated reduction can change their signs: "
            "store the reduced body (write_reduced_body) and continue with it, or start a new run"
        )
    if name == "shapes":
        return (
            f"{path} contains a motion of body '{body.name}' in {size} modes whose shapes are not those of "
            f"the given body, which has {body.n_coordinates}. On another computer, or with another number of "
            "threads, modes of equal frequency can be mixed: continue there, or start a new run"
        )
    return (
        f"{path} contains a motion of body '{body.name}' with another {name.replace('_', ' ')} than the "
        "given body: continue with the original body, or start a new run"
    )


def _measures(placed: Placed) -> Iterator[tuple[str, np.ndarray]]:
    """Measures that identify an elastic body and its initial deformation, by name; none for a rigid body."""
    body = placed.body
    of_body = list(_of_body(body))
    yield from of_body
    for name in ("coordinates", "coordinate_rates") if of_body else ():
        yield f"initial_{name}", np.array([getattr(placed, name) @ probe(body.n_coordinates)])


def _roots(matrix: np.ndarray) -> np.ndarray:
    """Square roots of the eigenvalues of the symmetric part of a matrix, which round-off hardly changes."""
    return np.sqrt(np.abs(np.linalg.eigvalsh((matrix + matrix.T) / 2)))


def _of_body(body: BodyForm) -> Iterator[tuple[str, np.ndarray]]:
    """Names of arrays of an elastic body, with their measures."""
    match body:
        case ReducedBody():
            for name in _ARRAYS:
                if (array := getattr(body, name)) is not None:
                    yield name, measures(array)
            # Stiff columns dominate the products above; the frequencies also identify soft modes.
            yield "frequencies", _roots(body.stiffness)
            yield "damping_of_modes", _roots(body.damping)
            for each in body.interfaces:
                own = each.position, each.motion.T @ probe(6), [each.cubic_turn], each.softness
                yield f"interface '{each.name}'", np.concatenate(own)
        case FullBody():
            one, other = probe(body.n_coordinates), probe(body.n_coordinates, seed=1)
            for name in ("stiffness", "mass"):
                matrix = getattr(body.body, name)
                yield name, np.array([one @ (matrix @ one), one @ (matrix @ other)])
            yield "frame", body.frame.constraint(body.body) @ one
        case ModalSubdomain():
            yield "shapes", measures(body.vectors)
            yield "frequencies", body.frequencies
            if body.spin_stiffness is not None:
                yield "stiffness_under_spin", measures(body.spin_stiffness.reshape(-1, body.n_modes))
        case IntrinsicBody():
            for name in ("velocities", "forces"):
                array = getattr(body.modes, name)
                yield name, measures(array.reshape(-1, array.shape[-1]))

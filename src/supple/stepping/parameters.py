"""Numbers of a machine that an exported one may change: what depends on them, and how.

Everything that the march reads of a machine, its arrays and the state that it starts from, is taken as affine
in the parameters, `a(p) = a(p_0) + sum_k (p_k - p_0k) da/dp_k`, and that is checked with the machine made
anew at other values. So an exported machine needs none of the code that makes arrays of a case.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from supple.errors import ModelError
from supple.machine import System
from supple.quantities import Quantity
from supple.stepping.variables import Variable

__all__ = ["AffineArrays", "MachineParameters", "affine_arrays"]

_STEP = 2.0**-6
"""Of a parameter, relative to it: exact in binary, so that slopes of linear arrays are."""
_ROUNDING = 1e-12
"""Of the largest entry of an array: what is less is no change."""
_AFFINE = 1e-10
"""The same, of what is left unexplained at the values of the check."""

Exported = tuple[System, Sequence[Quantity], Mapping[str, Any]]


@dataclass(frozen=True, eq=False)
class MachineParameters:
    """Numbers that an exported machine may change.

    variables : with the values that the machine has
    machine : system, sensors and inputs with other values (k,)
    """

    variables: tuple[Variable, ...]
    machine: Callable[[NDArray[np.float64]], Exported]

    @property
    def start(self) -> NDArray[np.float64]:
        """(k,) values of the machine."""
        return np.array([variable.start for variable in self.variables])


@dataclass(frozen=True, eq=False)
class AffineArrays:
    """Arrays in a structure, and their slopes.

    slopes : by the number of the array, those that are not zero: parameter and slope
    """

    base: Any
    start: NDArray[np.float64]
    slopes: Mapping[int, tuple[tuple[int, np.ndarray], ...]]

    def at(self, values: Any) -> Any:
        """The structure at other values (k,) of the parameters."""
        leaves, structure = jax.tree.flatten(self.base)
        for place, slopes in self.slopes.items():
            total: Any = leaves[place]
            for k, slope in slopes:
                total = total + (values[k] - self.start[k]) * jnp.asarray(slope)
            leaves[place] = total
        return jax.tree.unflatten(structure, leaves)

    def depend(self, part: Callable[[Any], Any]) -> set[int]:
        """Numbers of the parameters on which a part of the structure depends."""
        numbered = jax.tree.unflatten(
            jax.tree.structure(self.base), list(range(len(jax.tree.leaves(self.base))))
        )
        return {k for place in jax.tree.leaves(part(numbered)) for k, _ in self.slopes.get(place, ())}


def affine_arrays(made: Callable[[NDArray[np.float64]], Any], parameters: MachineParameters) -> AffineArrays:
    """The arrays that `made` makes at values of the parameters, as affine functions of these.

    Raises ModelError for a parameter that changes nothing or another program, and for arrays that depend on
    them otherwise.
    """
    start = parameters.start
    base = made(start)
    known = jax.tree.leaves(base)
    steps = _STEP * np.where(start == 0.0, 1.0, np.abs(start))
    slopes: dict[int, list[tuple[int, np.ndarray]]] = {}
    for k, variable in enumerate(parameters.variables):
        moved = start.copy()
        moved[k] += steps[k]
        found = 0
        for place, (old, new) in enumerate(zip(known, _alike(base, made(moved), variable.name), strict=True)):
            change = _difference(old, new)
            if change.any():
                slopes.setdefault(place, []).append((k, change / steps[k]))
                found += 1
        if not found:
            raise ModelError(
                f"parameter '{variable.name}' changes nothing in the march: it is fixed by then (of a "
                "reduced body), or belongs to an input"
            )
    found = AffineArrays(base, start, {place: tuple(own) for place, own in slopes.items()})
    _check(found, made, start + steps * (0.5 + 0.25 * (-1.0) ** np.arange(len(start))), parameters)
    return found


def _alike(base: Any, other: Any, name: str) -> list[Any]:
    """The leaves of a structure that differs from another one in its numbers alone."""
    leaves = jax.tree.leaves(other)
    if jax.tree.structure(base) != jax.tree.structure(other) or any(
        np.shape(one) != np.shape(two) for one, two in zip(jax.tree.leaves(base), leaves, strict=True)
    ):
        raise ModelError(f"parameter '{name}' changes the program of the machine: export one for each value")
    return leaves


def _difference(old: Any, new: Any) -> np.ndarray:
    """Of two arrays, without what is rounding."""
    if callable(old):
        return np.zeros(0)
    one, two = np.asarray(old, dtype=float), np.asarray(new, dtype=float)
    with np.errstate(invalid="ignore"):
        change = np.where(one == two, 0.0, two - one)
    size = np.abs(one[np.isfinite(one)]).max(initial=0.0)
    return np.where(np.abs(change) <= _ROUNDING * size, 0.0, change)


def _check(
    found: AffineArrays, made: Callable[[NDArray[np.float64]], Any], at: Any, parameters: MachineParameters
) -> None:
    """ModelError where arrays at a point between are others."""
    expected = jax.tree.leaves(found.at(at))
    actual = jax.tree.leaves(made(at))
    base = jax.tree.leaves(found.base)
    for place, slopes in found.slopes.items():
        scale = max(
            np.abs(base[place]).max(initial=0.0), np.abs(_difference(base[place], actual[place])).max()
        )
        error = np.abs(_difference(expected[place], actual[place])).max(initial=0.0)
        if not error <= _AFFINE * scale:
            names = ", ".join(f"'{parameters.variables[k].name}'" for k, _ in slopes)
            raise ModelError(
                f"the machine does not depend linearly on {names}: take another number of the same thing "
                "(a frequency, not its period), one of several that multiply each other, or export one "
                "machine for each value"
            )

"""Parameters of an exported machine: its arrays as affine functions of some numbers.

The arrays and the initial state of a machine are assumed to be affine functions of the parameters,
`a(p) = a(p_0) + sum_k (p_k - p_0k) da/dp_k`. This is checked against arrays built from other values. An
exported machine therefore does not contain the code that builds the arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray, FloatArray, Tree
from supple.errors import ModelError
from supple.machine import System
from supple.quantities import Quantity
from supple.stepping.external_inputs import Driven
from supple.stepping.variables import Variable

_STEP = 2.0**-6
"""Step of a parameter for slopes, relative to its value, or absolute for a value of zero; a power of two, for
which slopes of linear arrays are exact."""
_ROUNDING = 1e-12
"""Largest change of an entry that counts as rounding, as a fraction of the largest entry of the array."""
_AFFINE = 1e-10
"""Allowed deviation from the affine function in the check, as a fraction of the largest entry of the array
or, if larger, of its change."""

Exported = tuple[System, Sequence[Quantity], Mapping[str, Driven]]


@dataclass(frozen=True, eq=False)
class MachineParameters:
    """Parameters of an exported machine, and a function that builds the machine for other values.

    variables : parameters with their initial values
    machine : function, values (k,) -> system, sensors and inputs with these values
    """

    variables: tuple[Variable, ...]
    machine: Callable[[FloatArray], Exported]

    @property
    def start(self) -> FloatArray:
        """Initial values (k,) of the parameters."""
        return np.array([variable.start for variable in self.variables])


@dataclass(frozen=True, eq=False)
class AffineArrays:
    """A pytree of arrays that are affine functions of parameters.

    base : the pytree at the values `start` (k,)
    slopes : by index of a leaf, its nonzero slopes as pairs (index of the parameter, slope)
    """

    base: Tree
    start: FloatArray
    slopes: Mapping[int, tuple[tuple[int, np.ndarray], ...]]

    def at(self, values: AnyArray) -> Tree:
        """The pytree at values (k,) of the parameters."""
        leaves, structure = jax.tree.flatten(self.base)
        for place, slopes in self.slopes.items():
            total: AnyArray = leaves[place]
            for k, slope in slopes:
                total = total + (values[k] - self.start[k]) * jnp.asarray(slope)
            leaves[place] = total
        return jax.tree.unflatten(structure, leaves)

    def depend(self, part: Callable[[Tree], Tree]) -> set[int]:
        """Indices of the parameters on which a part of the pytree depends."""
        numbered = jax.tree.unflatten(
            jax.tree.structure(self.base), list(range(len(jax.tree.leaves(self.base))))
        )
        return {k for place in jax.tree.leaves(part(numbered)) for k, _ in self.slopes.get(place, ())}


def affine_arrays(made: Callable[[FloatArray], Tree], parameters: MachineParameters) -> AffineArrays:
    """The arrays `made(values)` as affine functions of the parameters.

    Raises ModelError for a parameter that changes no array, or the structure of the arrays, and for arrays
    that are not affine functions.
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
                f"parameter '{variable.name}' changes nothing in the equations of motion: it acts earlier "
                "(in a reduction), or an input replaces it; choose another one"
            )
    found = AffineArrays(base, start, {place: tuple(own) for place, own in slopes.items()})
    _check(found, made, start + steps * (0.5 + 0.25 * (-1.0) ** np.arange(len(start))), parameters)
    return found


def _alike(base: Tree, other: Tree, name: str) -> list[AnyArray]:
    """The leaves of `other`; ModelError if its structure or shapes differ from those of `base`."""
    leaves = jax.tree.leaves(other)
    if jax.tree.structure(base) != jax.tree.structure(other) or any(
        np.shape(one) != np.shape(two) for one, two in zip(jax.tree.leaves(base), leaves, strict=True)
    ):
        raise ModelError(
            f"parameter '{name}' changes the structure of the equations: export one machine for each value"
        )
    return leaves


def _difference(old: AnyArray, new: AnyArray) -> np.ndarray:
    """The difference of two arrays, with rounding errors set to zero."""
    if callable(old):
        return np.zeros(0)
    one, two = np.asarray(old, dtype=float), np.asarray(new, dtype=float)
    with np.errstate(invalid="ignore"):
        change = np.where(one == two, 0.0, two - one)
    size = np.abs(one[np.isfinite(one)]).max(initial=0.0)
    return np.where(np.abs(change) <= _ROUNDING * size, 0.0, change)


def _check(
    found: AffineArrays,
    made: Callable[[FloatArray], Tree],
    at: FloatArray,
    parameters: MachineParameters,
) -> None:
    """ModelError if the arrays built from the values `at` differ from the affine functions."""
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
                f"the machine does not depend linearly on {names}: choose a number on which it does (a "
                "frequency, not a period), only one of several numbers that are multiplied, or export one "
                "machine for each value"
            )

"""Lines of a machine, of which those of equal structure are stacked and evaluated together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

from supple.arrays import AnyArray, Tree
from supple.methods.intrinsic.line_model import LineModel
from supple.programs.program_cache import CachedProgram

T = TypeVar("T")


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class EqualLines(Sequence[LineModel]):
    """Models of the lines of a machine in their order; models that differ in numbers only are stacked.

    stacks : models, each of one line, or of several with a first axis of lines
    members : numbers of the lines of each stack
    """

    stacks: tuple[LineModel, ...]
    members: tuple[tuple[int, ...], ...] = field(metadata={"static": True})

    @classmethod
    def of(cls, models: Sequence[LineModel]) -> EqualLines:
        """The models, stacked."""
        members = _alike([(model,) for model in models])
        return cls(tuple(_stacked([models[number] for number in own]) for own in members), members)

    def __len__(self) -> int:
        return sum(map(len, self.members))

    def __getitem__(self, line: Any) -> Any:
        """The model of a line."""
        for stack, own in zip(self.stacks, self.members, strict=True):
            if line in own:
                return _taken(stack, own.index(line)) if len(own) > 1 else stack
        raise IndexError(line)


def for_each_line(
    function: Callable[..., T], models: Sequence[LineModel], *columns: Sequence[Tree]
) -> tuple[T, ...]:
    """Results of `function(model, ..)` for each line.

    `EqualLines` whose arguments differ in numbers only are evaluated together: a rotor of three equal blades
    is traced and compiled as one blade. Other sequences are evaluated line by line.

    columns : further arguments, one for each line; pytrees of arrays, or None
    """
    if not isinstance(models, EqualLines):
        return tuple(function(*own) for own in zip(models, *columns, strict=True))
    arguments = list(zip(*columns, strict=True))
    results: dict[int, T] = {}
    for stack, members in zip(models.stacks, models.members, strict=True):
        groups = _alike([arguments[line] for line in members])
        for group in groups:
            own = [arguments[members[k]] for k in group]
            if len(members) == 1:
                results[members[0]] = function(stack, *own[0])
            elif len(group) == 1:
                results[members[group[0]]] = function(_taken(stack, group[0]), *own[0])
            else:
                chosen = stack if len(groups) == 1 else _taken(stack, np.array(group))
                found = jax.vmap(function)(chosen, *_stacked(own))
                results |= {members[k]: _taken(found, place) for place, k in enumerate(group)}
    return tuple(results[line] for line in range(len(results)))


def _alike(arguments: Sequence[tuple[Tree, ...]]) -> tuple[tuple[int, ...], ...]:
    """Numbers of the arguments of equal structure, shapes and types, group by group."""
    groups: dict[object, list[int]] = {}
    for number, own in enumerate(arguments):
        groups.setdefault(CachedProgram.signature(*own), []).append(number)
    return tuple(map(tuple, groups.values()))


def _stacked(trees: Sequence[Tree]) -> Tree:
    if len(trees) == 1:
        return trees[0]

    def stacked(*leaves: AnyArray) -> AnyArray:
        known = all(isinstance(leaf, np.ndarray) for leaf in leaves)
        return np.stack(leaves) if known else jnp.stack(leaves)

    return jax.tree.map(stacked, *trees)


def _taken(tree: Tree, number: int | np.ndarray) -> Tree:
    return jax.tree.map(lambda leaf: leaf[number], tree)

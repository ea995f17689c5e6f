"""Elimination order of the unknowns of a machine for little fill-in.

Bodies are nodes, and each joint or force between two bodies is an edge. Bodies whose removal leaves no closed
path form the border. The other bodies form trees: each body is eliminated after all of its children, together
with the equations of the joint to its parent; its Schur complement then involves its parent and the border
only. A root is eliminated together with its joints to the ground. Joints that close a path belong to the
border.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations
from typing import NamedTuple

from supple.equations.machine_model import Model
from supple.equations.places import Places

NONE = -1


class _Joint(NamedTuple):
    """A joint of the model by body numbers; -1 is the ground."""

    first: int
    second: int
    row: int
    """First equation of the joint"""
    size: int

    def other(self, body: int) -> int:
        """The body at the other end of the joint."""
        return self.second if body == self.first else self.first


@dataclass(frozen=True)
class EliminationTree:
    """Bodies in the order of their elimination, and the border, which is solved last."""

    bodies: tuple[int, ...]
    parents: tuple[int, ...]
    """Position of each body's parent in this order; for a root, the length of the order"""
    rows: tuple[tuple[Places, ...], ...]
    """Constraint equations eliminated together with each body"""
    border_bodies: tuple[int, ...]
    border_rows: tuple[Places, ...]


def elimination_tree(model: Model) -> EliminationTree:
    """The elimination order of a machine; it depends only on the static fields of the model."""
    joints = list(_joints(model))
    neighbours = _neighbours(model)
    border = _border(model, neighbours)
    trees = {body: others - border for body, others in neighbours.items() if body not in border}
    grounded = {body: 0 for body in neighbours}
    for joint in joints:
        if min(joint.first, joint.second) == NONE:
            grounded[max(joint.first, joint.second)] += joint.size
    order, parent_of = _children_first(trees, grounded)
    place = {body: i for i, body in enumerate(order)} | {NONE: len(order)}
    own: dict[int, list[Places]] = {body: [] for body in order}
    border_rows = []
    # A body is eliminated with one joint to its parent only, that with most equations: several joints could
    # overconstrain it.
    taken: set[int] = set()
    for joint in sorted(joints, key=lambda joint: -joint.size):
        rows = Places((joint.row,), joint.size)
        holder = next((b for b in joint[:2] if b in own and parent_of[b] == joint.other(b)), None)
        if holder is None or (parent_of[holder] != NONE and holder in taken):
            border_rows.append(rows)
        else:
            own[holder].append(rows)
            taken.add(holder)
    return EliminationTree(
        bodies=tuple(order),
        parents=tuple(place[parent_of[body]] for body in order),
        rows=tuple(tuple(own[body]) for body in order),
        border_bodies=tuple(sorted(border)),
        border_rows=tuple(border_rows),
    )


def _joints(model: Model) -> Iterator[_Joint]:
    for group in model.joints:
        for first, second, row in zip(
            group.first.bodies, group.second.bodies, group.rows.starts, strict=True
        ):
            yield _Joint(first, second, row, group.rows.size)


def _neighbours(model: Model) -> dict[int, set[int]]:
    """The neighbours of each body."""
    found: dict[int, set[int]] = {body: set() for body in range(len(model.sizes))}
    for group in (*model.joints, *model.forces):
        for first, second in zip(group.first.bodies, group.second.bodies, strict=True):
            if min(first, second) != NONE and first != second:
                found[first].add(second)
                found[second].add(first)
    for control in model.controllers:
        for first, second in permutations(control.bodies, 2):
            found[first].add(second)
    return found


def _border(model: Model, neighbours: dict[int, set[int]]) -> set[int]:
    """Bodies whose removal leaves trees: repeatedly, of those on closed paths, one with most neighbours."""
    left = {body: set(others) for body, others in neighbours.items()}

    def without(body: int) -> None:
        for other in left.pop(body):
            left[other].discard(body)

    border: set[int] = set()
    while left:
        ends = [body for body, others in left.items() if len(others) < 2]
        if not ends:
            ends = [max(left, key=lambda body: (len(left[body]), -model.sizes[body], -body))]
            border.update(ends)
        for body in ends:
            without(body)
    return border


def _children_first(trees: dict[int, set[int]], grounded: dict[int, int]) -> tuple[list[int], dict[int, int]]:
    """All bodies of the trees, children before parents, and their parents; roots are joined to the ground."""
    parent_of: dict[int, int] = {}
    order: list[int] = []
    for root in sorted(trees, key=lambda body: (-grounded[body], body)):
        if root in parent_of:
            continue
        parent_of[root], reached = NONE, [root]
        for body in reached:  # the list grows in the loop
            children = sorted(trees[body] - parent_of.keys())
            parent_of.update(dict.fromkeys(children, body))
            reached += children
        order += reversed(reached)
    return order, parent_of

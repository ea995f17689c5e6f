"""Reduction of a node set to one value per channel: the largest or the mean value, or that of one node."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from supple.arrays import FloatArray, IntArray

__all__ = ["Maximum", "Mean", "Nearest", "OverNodes"]


class MeasuredBlock(NamedTuple):
    """Values (t', N', c) of the channels at some times and some nodes."""

    times: slice
    nodes: slice
    values: FloatArray


class Combined(NamedTuple):
    """Channels (t, c), and indices (t, c) of the nodes with these values; None if there is no single node."""

    values: FloatArray
    nodes: IntArray | None


class OverNodes(Protocol):
    """Rule that gives one value per channel of a sensor on several nodes."""

    @property
    def words(self) -> str:
        """Description of the value for N nodes: "largest", ..."""
        ...

    def read(self, points: FloatArray) -> IntArray:
        """Indices of the nodes to evaluate, from the positions (N, 3) of all nodes."""
        ...

    def combined(self, blocks: Iterable[MeasuredBlock], shape: tuple[int, int, int]) -> Combined:
        """The channels, from blocks that together contain each of the values (t, N, c) once."""
        ...


class _OfAllNodes:
    def read(self, points: FloatArray) -> IntArray:
        """All nodes."""
        return np.arange(len(points))


@dataclass(frozen=True)
class Maximum(_OfAllNodes):
    """The value of largest magnitude over the nodes, with its sign, at every time and for every channel."""

    words: str = field(default="largest", init=False)

    def combined(self, blocks: Iterable[MeasuredBlock], shape: tuple[int, int, int]) -> Combined:
        """The values of largest magnitude, and their nodes, updated block by block."""
        n_times, _, n_channels = shape
        values = np.zeros((n_times, n_channels))
        nodes = np.full((n_times, n_channels), -1)
        for times, some, found in blocks:
            own = np.abs(found).argmax(axis=1)
            largest = np.take_along_axis(found, own[:, None], axis=1)[:, 0]
            larger = (nodes[times] < 0) | (np.abs(largest) > np.abs(values[times]))
            values[times] = np.where(larger, largest, values[times])
            nodes[times] = np.where(larger, own + some.start, nodes[times])
        return Combined(values, nodes)


@dataclass(frozen=True)
class Mean(_OfAllNodes):
    """The mean over the nodes, with equal weights."""

    words: str = field(default="mean", init=False)

    def combined(self, blocks: Iterable[MeasuredBlock], shape: tuple[int, int, int]) -> Combined:
        """The mean values, from sums updated block by block; no nodes."""
        n_times, n_nodes, n_channels = shape
        total = np.zeros((n_times, n_channels))
        for times, _, found in blocks:
            total[times] += found.sum(axis=1)
        return Combined(total / n_nodes, None)


@dataclass(frozen=True)
class Nearest(Maximum):
    """The values at the node nearest to the centroid of all nodes."""

    words: str = field(default="nearest to the centroid", init=False)

    def read(self, points: FloatArray) -> IntArray:
        """The nearest node."""
        return np.array([np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))])

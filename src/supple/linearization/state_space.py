"""A linearised machine as a control engineer knows it: A, B, C, D."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from supple.arguments import check_sequence
from supple.errors import ModelError
from supple.linearization.linear_machine import Array, LinearMachine
from supple.linearization.ports import Port
from supple.linearization.sparse_machine import SparseMachine

__all__ = ["Acceleration", "StateSpace", "Velocity", "state_space"]


@dataclass(frozen=True)
class Velocity:
    """The rate of a port's motion, as output; of a machine that turns, seen in axes that turn along."""

    of: Port

    @property
    def label(self) -> str:
        """Of the port."""
        return f"velocity of {self.of.label}"


@dataclass(frozen=True)
class Acceleration:
    """The second derivative of a port's motion, as output, in the same axes."""

    of: Port

    @property
    def label(self) -> str:
        """Of the port."""
        return f"acceleration of {self.of.label}"


@dataclass(frozen=True, eq=False)
class StateSpace:
    """`x' = A x + B u`, `z = C x + D u`, with `x = (y, y')` of the `LinearMachine`.

    a : (2k, 2k)    b : (2k, ni)    c : (no, 2k)    d : (no, ni)
    inputs, outputs : their names
    """

    a: Array
    b: Array
    c: Array
    d: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """`(A, B, C, D)`, as `scipy.signal.StateSpace(*..)` and `control.ss(*..)` take them."""
        return self.a, self.b, self.c, self.d

    def write_matlab(self, path: str | Path) -> Path:
        """Write A, B, C, D and the names as a MATLAB file (.mat, version 5)."""
        path = Path(path)
        names = {
            name: np.array(labels, dtype=object)
            for name, labels in (("inputs", self.inputs), ("outputs", self.outputs))
        }
        scipy.io.savemat(path, {"A": self.a, "B": self.b, "C": self.c, "D": self.d, **names})
        return path


def state_space(
    machine: LinearMachine | SparseMachine,
    *,
    inputs: Sequence[Port],
    outputs: Sequence[Port | Velocity | Acceleration],
) -> StateSpace:
    """The linearised machine between forces at some ports and motions at others.

        A = [[0, 1], [-M^-1 K, -M^-1 C]],    B = [[0], [M^-1 b^T]],    C, D by rows

    A port `c` gives the row `(c, 0)`, its velocity `(0, c)`, its acceleration `c (-M^-1 K, -M^-1 C)` and the
    feedthrough `c M^-1 b^T`.
    Raises ModelError without an input or output, and for a machine with full bodies.
    """
    if isinstance(machine, SparseMachine):
        raise ModelError(
            f"a machine with full bodies has {2 * machine.size} states, too many for a state space: reduce "
            "its bodies, reduce(body, frame, basis), whose responses converge with their columns"
        )
    for name, ports in (("inputs", inputs), ("outputs", outputs)):
        check_sequence(f"state_space, {name}", ports, "a list of ports, also of a single one")
        if not ports:
            raise ModelError(f"a state space needs {name}: name at least one port")
    k = machine.size
    pushed = np.array([port.row(machine) for port in inputs]).T
    solved = np.linalg.solve(machine.mass, np.column_stack([machine.stiffness, machine.damping, pushed]))
    acceleration, by_force = -solved[:, : 2 * k], solved[:, 2 * k :]
    rows, through = [], []
    for output in outputs:
        row, feed = _row(machine, output, acceleration, by_force)
        rows.append(row)
        through.append(feed)
    return StateSpace(
        a=np.vstack([np.eye(k, 2 * k, k), acceleration]),
        b=np.vstack([np.zeros_like(by_force), by_force]),
        c=np.array(rows),
        d=np.array(through),
        inputs=tuple(port.label for port in inputs),
        outputs=tuple(port.label for port in outputs),
    )


def _row(machine: LinearMachine, output: Any, acceleration: Array, by_force: Array) -> tuple[Array, Array]:
    """Rows of C (2k,) and D (ni,)."""
    none, silent = np.zeros(machine.size), np.zeros(by_force.shape[1])
    if isinstance(output, Velocity):
        return np.concatenate([none, output.of.row(machine)]), silent
    if isinstance(output, Acceleration):
        own = output.of.row(machine)
        return own @ acceleration, own @ by_force
    return np.concatenate([output.row(machine), none]), silent

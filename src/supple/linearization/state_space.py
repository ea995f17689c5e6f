"""State space A, B, C, D of a linearised machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy  # its parts are imported when first used

from supple.arguments import check_sequence
from supple.errors import ModelError
from supple.linearization.base_motion import BaseAccelerationPort
from supple.linearization.linear_machine import Array, LinearMachine
from supple.linearization.machine_modes import free_motions
from supple.linearization.ports import Port, TranslationPort
from supple.linearization.sparse_machine import SparseMachine

__all__ = ["Acceleration", "StateSpace", "Velocity", "state_space"]


_COUPLED = 1e-9
"""Smallest acceleration along free motions, relative to that of the whole machine, that is not rounding."""


@dataclass(frozen=True)
class _Derivative:
    of: Port

    @property
    def label(self) -> str:
        """Label of the port, with the kind of derivative."""
        return f"{type(self).__name__.lower()} of {self.of.label}"


class Velocity(_Derivative):
    """The rate of a port's motion, as output; for a rotating machine, in co-rotating axes."""


class Acceleration(_Derivative):
    """The second derivative of a port's motion, as output, in the axes of `Velocity`."""


Output = Port | Velocity | Acceleration


@dataclass(frozen=True, eq=False)
class StateSpace:
    """`x' = A x + B u`, `w = C x + D u`, with `x = (y, y', z)` of the `LinearMachine`, z of its controllers.

    a : (m, m)    b : (m, ni)    c : (no, m)    d : (no, ni),    m = 2 k + number of states z
    inputs, outputs : names of u and of w
    drifts : (no, ni)   whether a constant input accelerates the output for ever, as of a free satellite
    """

    a: Array
    b: Array
    c: Array
    d: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    drifts: Array

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """`(A, B, C, D)`, the arguments of `scipy.signal.StateSpace(*..)` and `control.ss(*..)`."""
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
    outputs: Sequence[Output],
) -> StateSpace:
    """The linearised machine between forces at some ports and motions at others.

            [    0        1        0    ]        [    0    ]
        A = [ -M^-1 K  -M^-1 C   M^-1 H ],   B = [ M^-1 b^T ],    C, D by rows
            [   E_p      E_v      E_z   ]        [    0    ]

    b contains the rows of the input ports (`Port.row`). For a port with the row c, C has the row `(c, 0, 0)`
    if the output is its motion, and `(0, c, 0)` if it is its velocity. For its acceleration, C has c times
    the second row of A, and D has `c M^-1 b^T`. Accelerations include that of the base, if it is an input.
    The loops of controllers are closed.
    Raises ModelError without an input or output, for full bodies, and for periodic equations.
    """
    if isinstance(machine, SparseMachine):
        raise ModelError(
            f"a machine with full bodies has {2 * machine.size} states, too many for a state space: reduce "
            "its bodies, reduce(body, frame, basis), whose responses converge with their columns"
        )
    if machine.periodic is not None:
        raise ModelError(
            "the equations of the machine are periodic in its rotation, and a state space needs constant "
            "ones: machine_modes computes its Floquet modes"
        )
    for name, ports in (("inputs", inputs), ("outputs", outputs)):
        check_sequence(f"state_space, {name}", ports, "a list of ports, also of a single one")
        if not ports:
            raise ModelError(f"a state space needs {name}: give at least one port")
    for output in outputs:
        if isinstance(getattr(output, "of", output), BaseAccelerationPort):
            raise ModelError("the acceleration of the base is an input; as output give ports of the bodies")
    k, control = machine.size, machine.control
    pushed = np.array([port.row(machine) for port in inputs]).T
    loads = np.column_stack([-machine.stiffness, -machine.damping, control.forces, pushed])
    acceleration, by_force = np.split(np.linalg.solve(machine.mass, loads), [2 * k + control.size], axis=1)
    rows, through = [], []
    for output in outputs:
        row, feed = _row(machine, output, acceleration, by_force)
        rows.append(row)
        through.append(feed + _of_base(output, inputs))
    return StateSpace(
        a=np.vstack([np.eye(k, 2 * k + control.size, k), acceleration, np.hstack(control[1:])]),
        b=np.vstack([np.zeros_like(by_force), by_force, np.zeros((control.size, by_force.shape[1]))]),
        c=np.array(rows),
        d=np.array(through),
        inputs=tuple(port.label for port in inputs),
        outputs=tuple(port.label for port in outputs),
        drifts=_drifts(machine, pushed, outputs),
    )


def _drifts(machine: LinearMachine, pushed: Array, outputs: Sequence[Output]) -> Array:
    """Whether inputs (k, ni) accelerate outputs along free motions.

    False for machines with controllers or in rotation, whose forces may balance the input in motion.
    """
    if machine.system.controllers or (machine.spin is not None and machine.spin.rate):
        return np.zeros((len(outputs), pushed.shape[1]), dtype=bool)
    ports = [output.of if isinstance(output, _Derivative) else output for output in outputs]
    seen = np.array([port.row(machine) for port in ports])
    lower = np.linalg.cholesky(machine.mass)
    sizes = [np.linalg.norm(np.linalg.solve(lower, each), axis=0) for each in (seen.T, pushed)]
    free = free_motions(machine)
    return abs(seen @ free @ (free.T @ pushed)) > _COUPLED * np.outer(*sizes)


def _of_base(output: Output, inputs: Sequence[Port]) -> Array:
    """Share (ni,) of each input in an absolute acceleration beside the motion relative to the base."""
    along = np.zeros(3)
    if isinstance(output, Acceleration) and isinstance(output.of, TranslationPort):
        along = np.array(output.of.direction)
    return np.array(
        [along @ port.direction if isinstance(port, BaseAccelerationPort) else 0.0 for port in inputs]
    )


def _row(machine: LinearMachine, output: Output, acceleration: Array, by_force: Array) -> tuple[Array, Array]:
    """Rows of C (m,) and D (ni,) for an output."""
    own = (output.of if isinstance(output, _Derivative) else output).row(machine)
    if isinstance(output, Acceleration):
        return own @ acceleration, own @ by_force
    before = np.zeros(machine.size if isinstance(output, Velocity) else 0)
    row = np.concatenate([before, own, np.zeros(acceleration.shape[1] - len(before) - len(own))])
    return row, np.zeros(by_force.shape[1])

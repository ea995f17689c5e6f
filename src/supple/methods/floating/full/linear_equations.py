"""Linear equations of machines with full bodies about a steady motion: sparse matrices of all freedoms.

The border consists of frames, reduced and rigid bodies, stations, and the motions `w = B q` of the interfaces
of full bodies. Its equations come from a compiled program. The sparse matrices of each full body in all its
coordinates q are added, and so are its six frame constraints `D q = 0`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array, hstack, vstack

from supple.algebra.cross import cross_matrix
from supple.equations.control_linearization import LinearControl
from supple.equations.station_body import StationBody
from supple.equations.steady_motion import SteadyRotation, frame_axes, linear_equations
from supple.methods.floating.full.full_state import Evaluation, LineEvaluation
from supple.methods.floating.full.full_system import FullSystem


class SparseEquations(NamedTuple):
    """`M p'' + (C + W S W^T) p' + K p + A^T l = H z`, `A p = 0`, in axes that rotate with the bodies."""

    mass: csr_array
    """Sparse (n, n), regular on the motions that satisfy the constraints"""
    damping: csr_array
    """Sparse (n, n), with the gyroscopic terms"""
    damping_columns: np.ndarray
    """`W` (n, w): columns of damped modes, and of mass-proportional damping relative to an interface"""
    damping_signs: np.ndarray
    """Diagonal of `S`, (w,), each 1 or -1"""
    stiffness: csr_array
    """Sparse (n, n), with centrifugal terms and the geometric stiffness of the steady forces"""
    constraint: csr_array
    """Sparse (m, n): constraints of joints, and of frames of full bodies"""
    interior: np.ndarray
    """Indices of the freedoms that are factored first: their block of K is sparse and regular"""
    control: LinearControl
    """`H`, and the rates of the states z of all controllers"""

    def damped(self, motions: np.ndarray) -> np.ndarray:
        """`(C + W S W^T) p` for k vectors p, (n, k)."""
        along = self.damping_signs[:, None] * (self.damping_columns.T @ motions)
        return self.damping @ motions + self.damping_columns @ along


def full_linear_equations(machine: FullSystem, turning: SteadyRotation, terms: Evaluation) -> SparseEquations:
    """Equations of motion linearised about a state in which every body rotates steadily."""
    border = linear_equations(
        machine.model, _border_turning(machine, turning), terms.border_motion, terms.border
    )
    border_map = to_border(machine, terms)
    states = dict(zip((each.index for each in machine.interiors), terms.interior_states, strict=True))
    inner = {
        each.index: _turning_parts(each.linear_parts(states[each.index]), states[each.index].angular_velocity)
        for each in machine.interiors
    }
    inner |= {
        body.index: _line_parts(body, line) for body, line in zip(machine.lines, terms.lines, strict=True)
    }
    mass, damping, stiffness = (
        csr_array(border_map.T @ csr_array(of_border) @ border_map)
        + _by_body(machine, {index: parts[number] for index, parts in inner.items()})
        for number, of_border in enumerate((border.mass, border.damping, border.stiffness))
    )
    columns = {each.index: _with_frame_zeros(each.damping.columns.T).T for each in machine.interiors}
    signs = {each.index: each.damping.signs for each in machine.interiors}
    return SparseEquations(
        mass=csr_array((mass + mass.T) / 2),
        damping=damping,
        damping_columns=_by_body(machine, columns, square=False).toarray(),
        damping_signs=np.concatenate([np.zeros(0), *(signs[index] for index in sorted(signs))]),
        stiffness=stiffness,
        constraint=csr_array(vstack([csr_array(border.constraint) @ border_map, frame_conditions(machine)])),
        interior=_interior(machine),
        control=border.control.along(border_map),
    )


def _turning_parts(parts: tuple[csr_array, ...], angular_velocity: np.ndarray) -> tuple[csr_array, ...]:
    """`M`, `C` and `K` (6 + n, 6 + n) of one body in axes that rotate with it, from those in fixed axes."""
    mass, damping, stiffness = parts
    if not angular_velocity.any():
        return parts
    spin, n = cross_matrix(angular_velocity), mass.shape[0]
    frame = csr_array(block_diag([spin, spin, csr_array((n - 6, n - 6))]))
    translation = csr_array(block_diag([spin, csr_array((n - 3, n - 3))]))
    return (
        mass,
        damping + mass @ (frame + translation),
        stiffness + damping @ frame + mass @ translation @ frame,
    )


def _line_parts(body: StationBody, line: LineEvaluation) -> tuple[csr_array, ...]:
    """`M`, `C` and `K` of a body with stations."""
    axes = frame_axes(len(line.residual), [0], line.state.rotation[None])
    own = (csr_array(axes.T @ part @ axes) for part in body.tangent(line.state, line.station_forces))
    return _turning_parts(tuple(own), line.state.velocity[3:6])


def _border_turning(machine: FullSystem, turning: SteadyRotation) -> SteadyRotation:
    """The steady rotation of the border: each station has the angular velocity of its body."""
    if not machine.lines:
        return turning
    rates = np.asarray(turning.angular_velocities)
    of_stations = [np.tile(rates[line.index], (line.n_stations, 1)) for line in machine.lines]
    others = np.delete(rates, list(machine.line_of), axis=0)
    return turning._replace(angular_velocities=np.concatenate([others, *of_stations]))


def to_border(machine: FullSystem, terms: Evaluation) -> csr_array:
    """Sparse matrix from the velocities of all freedoms to those of the border."""
    parts = {
        each.index: csr_array(block_diag([eye_array(6), each.interface_rows])) for each in machine.interiors
    }
    for body, line in zip(machine.lines, terms.lines, strict=True):
        rotations, size = line.stations.rotations, len(line.residual)
        parts[body.index] = csr_array(
            frame_axes(6 * len(rotations), range(0, 6 * len(rotations), 6), rotations).T
            @ line.stations.motion
            @ frame_axes(size, [0], line.state.rotation[None])
        )
    blocks = [
        csr_array(parts.get(index, eye_array(part.stop - part.start)))
        for index, part in enumerate(machine.slices)
    ]
    if not machine.lines:
        return csr_array(block_diag(blocks))
    rows = np.concatenate([np.arange(part.start, part.stop) for part in machine.border_slices])
    return csr_array(block_diag(blocks, format="csr")[np.argsort(rows)])


def frame_conditions(machine: FullSystem) -> csr_array:
    """`D` of all full bodies, (6 b, n)."""
    rows = {each.index: _with_frame_zeros(each.frame_rows).T for each in machine.interiors}
    return csr_array(_by_body(machine, rows, square=False).T)


def _with_frame_zeros(rows: np.ndarray) -> csr_array:
    """Rows (k, 6 + n): six zeros for the frame, then the rows (k, n) for the coordinates of a body."""
    return csr_array(hstack([csr_array((len(rows), 6)), csr_array(rows)]))


def _by_body(machine: FullSystem, parts: Mapping[int, csr_array], *, square: bool = True) -> csr_array:
    """Block-diagonal matrix of all bodies, from blocks by index of the body; zero for other bodies."""
    sizes = [part.stop - part.start for part in machine.slices]
    blocks = [parts.get(i, csr_array((size, size if square else 0))) for i, size in enumerate(sizes)]
    return csr_array(block_diag(blocks))


def _interior(machine: FullSystem) -> np.ndarray:
    """Indices among all freedoms: coordinates of full bodies, without six per body.

    With these six held, the body has no rigid motion, so its stiffness matrix is regular. In a machine
    without full bodies: indices of the coordinates of bodies with stations.
    """
    found = [np.zeros(0, dtype=int)]
    for interior in machine.interiors:
        body = interior.full.body
        held = body.grounded_stiffness.springs
        found.append(machine.slices[interior.index].start + 6 + np.setdiff1d(np.arange(body.n), held))
    if not machine.interiors:
        parts = [machine.slices[line.index] for line in machine.lines]
        found += [np.arange(part.start + 6, part.stop) for part in parts]
    return np.concatenate(found)

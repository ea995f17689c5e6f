"""Stress and strain over time of any elastic body, reduced, full or intrinsic."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm
from supple.body.floating_kinematics import checked_nodes
from supple.body.tied_recovery import inner_pieces, tied_recovery, with_virtual_freedoms
from supple.fem import FiniteElementModel, StressRecovery, stress_layers, stress_recovery, von_mises
from supple.quantities.tensor_modes import STRESS, NodalTensor, tensor_modes
from supple.reduction import ReducedBody

__all__ = ["LargestStress", "largest_stress", "von_mises_by_end", "von_mises_history"]

# Numbers in memory at a time: modes of some nodes (128 MiB), and the field at some times (32 MiB).
_MODE_NUMBERS, _FIELD_NUMBERS = 2**24, 2**22
# Largest number of values of modes cached for many calls (1 GiB).
_KEPT_NUMBERS = 2**27
# Number of times, evenly spaced and at extremes, at which all nodes are searched for the largest stress;
# number of candidate nodes.
_SEARCHED = 100


class TensorBlock(NamedTuple):
    """A tensor field at some of the evaluated times and nodes."""

    times: slice
    nodes: slice
    field: FloatArray
    """(t', N', l, 6)"""


def von_mises_history(
    body: BodyForm,
    model: FiniteElementModel,
    coordinates: FloatArray,
    nodes: ArrayLike | None = None,
) -> FloatArray:
    """Largest von Mises stress over the layers (t, N), in the unit of stress, at coordinates (t, r).

    The stress of a reduced body follows from its stress modes. The stress at few times, of a full body, or of
    a reduced body with nonlinear forces beyond its tensors (`ReducedBody.elastic_elsewhere`), is recovered
    from nodal displacements. In elements at rigid interfaces, the strain includes the second-order motion of
    tied nodes (`tied_recovery`). A linear body has the stress of its linear strain; an intrinsic body has the
    stress of the static shapes of its section loads.

    Parameters
    ----------
    model : FiniteElementModel      the model of the body
    nodes : int array (N,)          numbers of the nodes of interest; all by default

    Raises
    ------
    ModelError   as for stress_modes
    """
    n_nodes = len(body.nodes) if nodes is None else np.size(nodes)
    found = np.zeros((len(coordinates), n_nodes))
    if has_modes(body) and _are_worth(body, len(coordinates)):
        chosen = np.arange(n_nodes) if nodes is None else checked_nodes(nodes, len(body.nodes))
        for some in _slices_of_modes(body, model, n_nodes):
            found[:, some] = tensor_modes(STRESS, body, model, chosen[some]).von_mises(coordinates)
        return found
    for block in _recovered(body, STRESS.recovery(model), coordinates, nodes):
        found[block.times, block.nodes] = STRESS.equivalent(block.field).max(axis=2)
    return found


def tensor_blocks(
    tensor: NodalTensor, body: BodyForm, model: FiniteElementModel, coordinates: FloatArray, nodes: ArrayLike
) -> Iterator[TensorBlock]:
    """A tensor at N nodes over t times, in blocks that fit in memory.

    The tensor has l layers (`StressLayers`). Every pair of a time and a node is in exactly one block. Raises
    the errors of `von_mises_history`.
    """
    if not (has_modes(body) and _are_worth(body, len(coordinates))):
        yield from _recovered(body, tensor.recovery(model), coordinates, nodes)
        return
    chosen = checked_nodes(nodes, len(body.nodes))
    for some in _slices_of_modes(body, model, len(chosen)):
        modes = tensor_modes(tensor, body, model, chosen[some])
        for times in _slices(len(coordinates), _FIELD_NUMBERS // modes.linear[..., 0].size):
            yield TensorBlock(times, some, modes.at(coordinates[times]))


def von_mises_by_end(body: BodyForm, model: FiniteElementModel, coordinates: FloatArray) -> FloatArray:
    """Von Mises stress (t, N, 1 + ends), unit of stress: largest of solids and shells, then of each beam end.

    The beam ends are those of `StressLayers`; the stress is zero where a node has fewer ends. Other
    parameters and errors are those of `von_mises_history`.
    """
    layers, nodes = stress_layers(model), nodes_with_stress(stress_recovery(model))
    found = np.zeros((len(coordinates), len(body.nodes), 1 + layers.ends))
    for times, some, field in tensor_blocks(STRESS, body, model, coordinates, nodes):
        found[times, nodes[some]] = layers.largest(STRESS.equivalent(field))
    return found


def equivalent_stress(body: BodyForm, model: FiniteElementModel) -> Callable[[FloatArray], FloatArray]:
    """Von Mises stress (t, N) at all nodes as a function of coordinates (t, r), for repeated calls.

    NaN at nodes without elements that have stress. Raises the errors of `von_mises_history`. Stress modes are
    computed once if they fit in 1 GiB.
    """
    nodes = nodes_with_stress(stress_recovery(model))
    at_nodes: Callable[[FloatArray], FloatArray] = partial(von_mises_history, body, model, nodes=nodes)
    if has_modes(body) and _numbers_of_modes(body, model) * len(nodes) <= _KEPT_NUMBERS:
        at_nodes = tensor_modes(STRESS, body, model, nodes).von_mises

    def at_all_nodes(coordinates: FloatArray) -> FloatArray:
        found = np.full((len(coordinates), len(body.nodes)), np.nan)
        found[:, nodes] = at_nodes(coordinates)
        return found

    return at_all_nodes


class LargestStress(NamedTuple):
    """The largest von Mises stress of a body over a run."""

    value: float
    instant: int
    """Index of the output time"""
    node: int


def largest_stress(body: BodyForm, model: FiniteElementModel, coordinates: FloatArray) -> LargestStress:
    """The largest von Mises stress over nodes, layers and times; errors as for `von_mises_history`.

    All nodes are evaluated at up to two hundred output times. A hundred of these are evenly spaced; at the
    others the most coordinates have an extreme, as in short events. The hundred nodes with the largest stress
    at these times are evaluated at all times. The result is exact for up to a hundred output times.
    """
    recovery = stress_recovery(model)
    nodes = nodes_with_stress(recovery)
    sampled = _searched_times(np.asarray(coordinates))
    highest = np.zeros(len(nodes))
    for block in _recovered(body, recovery, np.asarray(coordinates)[sampled], nodes):
        highest = np.maximum(highest, von_mises(block.field).max(axis=(0, 2)))
    candidates = nodes[np.sort(np.argsort(-highest, kind="stable")[:_SEARCHED])]
    largest = LargestStress(-1.0, 0, int(candidates[0]))
    for times, some, field in tensor_blocks(STRESS, body, model, coordinates, candidates):
        values = von_mises(field).max(axis=2)
        instant, node = np.unravel_index(int(values.argmax()), values.shape)
        if values[instant, node] > largest.value:
            number = int(candidates[some][node])
            largest = LargestStress(float(values[instant, node]), int(instant) + times.start, number)
    return largest


def _searched_times(coordinates: FloatArray) -> IntArray:
    """Indices of the output times at which all nodes are searched for the largest stress."""
    evenly = np.linspace(0, len(coordinates) - 1, _SEARCHED).astype(int)
    extremes = np.concatenate([coordinates.argmin(axis=0), coordinates.argmax(axis=0)])
    number = np.bincount(extremes, minlength=len(coordinates))
    most = np.argsort(-number, kind="stable")[: min(_SEARCHED, np.count_nonzero(number))]
    return np.unique(np.concatenate([evenly, most]))


def nodes_with_stress(recovery: StressRecovery) -> IntArray:
    """Numbers of the nodes of elements that have stress."""
    return np.unique(np.concatenate([section.nodes.ravel() for section in recovery.sections]))


def has_modes(body: BodyForm) -> TypeGuard[ReducedBody]:
    """Whether the stress of a body follows from stress modes."""
    return body.has_stress_modes


def _are_worth(body: ReducedBody, n_times: int) -> bool:
    """Whether modes cost less than recovery at every time: a mode costs as much as about half a time."""
    return 2 * n_times >= _modes_per_layer(body)


def _slices_of_modes(body: ReducedBody, model: FiniteElementModel, n_nodes: int) -> Iterator[slice]:
    """Blocks of nodes whose modes are in memory at a time."""
    return _slices(n_nodes, _MODE_NUMBERS // (_numbers_of_modes(body, model) or 1))


def _numbers_of_modes(body: ReducedBody, model: FiniteElementModel) -> int:
    """Number of entries in the modes of a node."""
    return 6 * stress_layers(model).count * _modes_per_layer(body)


def _modes_per_layer(body: ReducedBody) -> int:
    """Number of modes: one per coordinate, per product of two of them, and per field of condensed motion."""
    n_condensed = 0 if body.condensed is None else body.condensed.fields.shape[1]
    return body.r * (body.r + 3) // 2 + n_condensed


def _recovered(
    body: BodyForm, recovery: StressRecovery, coordinates: FloatArray, nodes: ArrayLike | None
) -> Iterator[TensorBlock]:
    """A tensor field from nodal displacements, in blocks of times; only the cells at the nodes are used.

    An intrinsic body has the linear displacements of its modes, because only strains matter.
    """
    chosen = np.arange(len(body.nodes))
    if nodes is not None:
        chosen = checked_nodes(nodes, len(body.nodes))
        recovery = recovery.around(chosen)
    if body.has_linear_strains:
        recovery = recovery.linearized()
    d, interfaces = body.dofs_per_node, body.interfaces
    inner = () if body.has_linear_strains else inner_pieces(recovery.pieces, body.nodes, d, interfaces)
    ties = (*interfaces, *inner)
    recovery = tied_recovery(recovery, body.nodes, d, ties)
    of_field = 6 * recovery.n_layers * len(chosen)
    size = _FIELD_NUMBERS // (recovery.numbers_per_instant + len(body.nodes) + of_field)
    averaging, linear = recovery.averaging_at(chosen), recovery.linearized()
    for times in _slices(len(coordinates), size):
        q = np.asarray(coordinates)[times]
        nodal, condensed = body.nodal_fields(q)
        motions = [interface.motion @ q.T for interface in interfaces]
        motions += [piece.motion @ nodal for piece in inner]
        field = recovery.over(with_virtual_freedoms(nodal, motions, ties, d), averaging)
        if condensed is not None:  # only linear strain, as in `tensor_modes`; interfaces are fixed
            still = [np.zeros_like(motion) for motion in motions]
            field += linear.over(with_virtual_freedoms(condensed, still, ties, d), averaging)
        yield TensorBlock(times, slice(0, len(chosen)), field)


def _slices(length: int, size: int) -> Iterator[slice]:
    for start in range(0, length, max(1, size)):
        yield slice(start, min(start + max(1, size), length))

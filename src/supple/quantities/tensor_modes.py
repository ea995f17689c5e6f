"""Stress or strain at nodes, as an exact polynomial in the reduced coordinates of a body."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from supple.arrays import FloatArray, IntArray
from supple.body.floating_kinematics import checked_nodes
from supple.body.tied_recovery import inner_pieces, tied_recovery, with_virtual_freedoms
from supple.errors import ModelError
from supple.fem import (
    FiniteElementModel,
    QuadraticStrain,
    StressRecovery,
    strain_recovery,
    stress_recovery,
    von_mises,
    von_mises_strain,
)
from supple.fem.stress import SectionStress
from supple.reduction import ReducedBody

__all__ = ["TensorModes", "strain_modes", "stress_modes"]


# Number of field values in memory at one time (32 MiB): all values of a long run of a large body do not fit.
_FIELD_NUMBERS = 2**22


class NodalTensor(NamedTuple):
    """A kind of symmetric tensor, components xx yy zz yz xz xy in the body's frame.

    recovery : function that returns for a model the `StressRecovery`, which computes the tensor at nodes
    equivalent : function that returns the von Mises equivalents (...) of tensors (..., 6)
    """

    recovery: Callable[[FiniteElementModel], StressRecovery]
    equivalent: Callable[[FloatArray], FloatArray]


STRESS = NodalTensor(stress_recovery, von_mises)
"""Second Piola-Kirchhoff stress, in the unit of stress."""
STRAIN = NodalTensor(strain_recovery, von_mises_strain)
"""Green-Lagrange strain, with engineering shears."""


def principal_values(stress: FloatArray) -> FloatArray:
    """Eigenvalues (..., 3), ascending, of tensors (..., 6)."""
    rows = stress[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
    return np.asarray(np.linalg.eigvalsh(rows), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class TensorModes:
    """Values of a tensor at nodes, per reduced coordinate gamma_j and per product of two coordinates.

        field(gamma) = linear (gamma, amplitudes m2) + quadratic m2
        m2 = (gamma_j gamma_k), j <= k as numpy.triu_indices(r)

    nodes : (N,)                        node numbers
    linear : (N, l, 6, r + m)           values in l layers, components xx yy zz yz xz xy in the body's frame:
                                        for the r basis columns, then for the m fields of the condensed motion
    quadratic : (N, l, 6, n2) or None   values per product m2, n2 = r(r+1)/2; None for a linear body
    amplitudes : (m, n2)                amplitudes of the m fields per product m2; m = 0 without condensed
                                        motion
    tensor : NodalTensor                stress or strain
    outer : (o,)                        layers in which the von Mises equivalent can be largest
    """

    nodes: IntArray
    linear: FloatArray
    quadratic: FloatArray | None
    amplitudes: FloatArray
    tensor: NodalTensor
    outer: tuple[int, ...]

    def __post_init__(self) -> None:
        for array in (self.nodes, self.linear, self.quadratic, self.amplitudes):
            if array is not None:
                array.setflags(write=False)

    @property
    def r(self) -> int:
        """Number of reduced coordinates."""
        return self.linear.shape[-1] - len(self.amplitudes)

    def at(self, coordinates: ArrayLike) -> FloatArray:
        """The field (..., N, l, 6) for coordinates (..., r); ModelError for another number of coordinates."""
        gamma = self._checked(coordinates)
        field = self._field(gamma.reshape(-1, self.r))
        return field.reshape(*gamma.shape[:-1], *self.linear.shape[:3])

    def von_mises(self, coordinates: ArrayLike) -> FloatArray:
        """The largest von Mises equivalent (..., N) over the layers of each node, for coordinates (..., r).

        It is computed in the layers `outer` only, for as many coordinate vectors at a time as fit in memory.
        """
        gamma = self._checked(coordinates)
        rows = gamma.reshape(-1, self.r)
        found = np.empty((len(rows), len(self.nodes)))
        faces = self.outer_layers()
        n_rows = max(1, _FIELD_NUMBERS // max(1, faces.linear[..., 0].size))
        for start in range(0, len(rows), n_rows):
            block = slice(start, start + n_rows)
            found[block] = self.tensor.equivalent(faces._field(rows[block])).max(axis=2)
        return found.reshape(*gamma.shape[:-1], -1)

    def of(self, nodes: slice) -> TensorModes:
        """The modes at some of the nodes, given as a slice of `nodes`."""
        quadratic = None if self.quadratic is None else self.quadratic[nodes]
        return replace(self, nodes=self.nodes[nodes], linear=self.linear[nodes], quadratic=quadratic)

    def outer_layers(self) -> TensorModes:
        """The modes in the layers `outer` only."""
        if len(self.outer) == self.linear.shape[1]:
            return self
        layers = list(self.outer)
        quadratic = None if self.quadratic is None else np.ascontiguousarray(self.quadratic[:, layers])
        linear = np.ascontiguousarray(self.linear[:, layers])
        return replace(self, linear=linear, quadratic=quadratic, outer=tuple(range(len(layers))))

    def _field(self, gamma: FloatArray) -> FloatArray:
        """The field (t, N, l, 6) for coordinates (t, r)."""
        j, k = np.triu_indices(self.r)
        products = gamma[:, j] * gamma[:, k]
        field = _times(self.linear, np.hstack([gamma, products @ self.amplitudes.T]))
        if self.quadratic is not None:
            field += _times(self.quadratic, products)
        return field

    def _checked(self, coordinates: ArrayLike) -> FloatArray:
        gamma = np.asarray(coordinates, dtype=np.float64)
        if gamma.ndim < 1 or gamma.shape[-1] != self.r:
            raise ModelError(
                f"coordinates of shape {gamma.shape}: these modes are of a body with {self.r} coordinates, "
                f"give (..., {self.r})"
            )
        return gamma


def stress_modes(body: ReducedBody, model: FiniteElementModel, nodes: ArrayLike | None = None) -> TensorModes:
    """Stress modes of a reduced body: matrices from which its stress at any time is a small matrix product.

        sigma(gamma) = S1 gamma + S2 (gamma gamma) + S3 z(gamma)

    gamma are the r reduced coordinates. S1 is the stress of each column of the basis, and S2 that of each
    pair of columns, from the quadratic part of the strain. Without S2, a body with large rotations relative
    to its frame, such as a bent blade, would have spurious stress. S3 is the stress of the condensed motion
    z, stiff motion that the basis does not contain. A linear body has S1 only. Memory for N nodes and l
    layers: 6 N l r numbers; for a nonlinear body also 6 N l r(r+1)/2, and 6 N l m for the m fields of z. If
    that is too much, give fewer nodes.

    Parameters
    ----------
    model : FiniteElementModel      from which the body was made
    nodes : int array (N,)          numbers of the nodes of interest; default: all nodes

    Raises
    ------
    ModelError   a model with other nodes or freedoms than the body, an unknown node number, a laminate
    """
    return tensor_modes(STRESS, body, model, nodes)


def strain_modes(body: ReducedBody, model: FiniteElementModel, nodes: ArrayLike | None = None) -> TensorModes:
    """Strain modes of a reduced body; parameters and errors as for `stress_modes`."""
    return tensor_modes(STRAIN, body, model, nodes)


def tensor_modes(
    tensor: NodalTensor, body: ReducedBody, model: FiniteElementModel, nodes: ArrayLike | None
) -> TensorModes:
    """The modes of a tensor of a body, at all or some of its nodes; errors as for `stress_modes`.

        eps = e gamma + 1/2 sum_jk N(a_j, a_k) gamma_j gamma_k,     e = B V,   a = G V

    is the exact strain at a point of an element; V is the basis, B and G are strain operators of the element,
    and N is the bilinear form of its nonlinear strain. Stress, and its mean at nodes, are linear in the
    strain. The condensed motion z adds B z to the strain, as it does in the energy; it does not rotate
    interfaces. In elements at rigid interfaces, the strain includes the second-order motion of tied nodes
    (`tied_recovery`).
    """
    same_count = body.nodal_basis.shape[0] == model.n_dofs and body.nodes.shape == model.mesh.nodes.shape
    if not (same_count and np.array_equal(body.nodes, model.mesh.nodes)):
        raise ModelError(
            f"body '{body.name}' ({len(body.nodes)} nodes of {body.dofs_per_node} freedoms) was not made of "
            f"this model ({model.mesh.n_nodes} nodes of {model.dofs_per_node}); give the model of the body"
        )
    recovery = tensor.recovery(model)
    chosen = np.arange(recovery.n_nodes) if nodes is None else checked_nodes(nodes, recovery.n_nodes)
    n_layers, r = recovery.n_layers, body.r
    rows = (chosen[:, None] * n_layers + np.arange(n_layers)).ravel()
    follows = body.condensed
    amplitudes = np.zeros((0, r * (r + 1) // 2)) if follows is None else follows.amplitudes
    interfaces, d = body.interfaces, body.dofs_per_node
    inner = () if body.is_linear else inner_pieces(recovery.pieces, body.nodes, d, interfaces)
    recovery = tied_recovery(recovery, body.nodes, d, (*interfaces, *inner))
    motions = [*(i.motion for i in interfaces), *(piece.motion @ body.nodal_basis for piece in inner)]
    fields = with_virtual_freedoms(body.nodal_basis, motions, (*interfaces, *inner), d)
    if follows is not None:
        behind = np.zeros((len(fields) - len(follows.fields), follows.fields.shape[1]))
        fields = np.hstack([fields, np.vstack([follows.fields, behind])])
    linear = np.zeros((len(rows), 6, fields.shape[1]))
    quadratic = None if body.is_linear else np.zeros((len(rows), 6, r * (r + 1) // 2))
    for section, averaging in zip(recovery.sections, recovery.averaging, strict=True):
        for part in _parts(section, averaging.tocsr()[rows], fields.shape[1]):
            columns = fields[part.arrays.dofs][:, None]
            part.add_to(linear, part.arrays.with_enhanced(part.arrays.B @ columns))
            if quadratic is not None:
                for pairs, strains in _pair_strains(part.arrays.N, part.arrays.G @ columns[..., :r]):
                    part.add_to(quadratic[..., pairs], part.arrays.with_enhanced(strains))
    layered = (len(chosen), n_layers, 6, -1)
    return TensorModes(
        nodes=chosen,
        linear=linear.reshape(layered),
        quadratic=None if quadratic is None else quadratic.reshape(layered),
        amplitudes=amplitudes,
        tensor=tensor,
        outer=recovery.layers.outer,
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """Some cells of a section, and the nodes to which they contribute.

    rows : (R,)                     indices of the rows of the field
    share : csr (R, E g l')         weights of the tensors of E cells at g points in l' layers
    arrays : QuadraticStrain        strain arrays of the E cells
    to_field : (E, 6 l', s)         tensors in l' layers from a strain with s components
    """

    rows: IntArray
    share: csr_array
    arrays: QuadraticStrain
    to_field: FloatArray

    def add_to(self, field: FloatArray, strains: FloatArray) -> None:
        """Add the tensors of strains (E, g, s, m), averaged at nodes, to a field (rows, 6, m)."""
        m = strains.shape[-1]
        tensors = (self.to_field[:, None] @ strains).reshape(-1, 6 * m)
        field[self.rows] += (self.share @ tensors).reshape(-1, 6, m)


def _parts(section: SectionStress, shares: csr_array, r: int) -> Iterator[_Part]:
    """The cells that contribute to any row of `shares`, in parts whose tensors fit in memory."""
    n_tensors = section.to_nodes.shape[2]
    cells = np.unique(shares.indices // n_tensors)
    size = max(1, _FIELD_NUMBERS // (n_tensors * 6 * r))
    by_tensor = shares.tocsc()
    for start in range(0, len(cells), size):
        some = cells[start : start + size]
        share = by_tensor[:, (some[:, None] * n_tensors + np.arange(n_tensors)).ravel()].tocsr()
        rows = np.flatnonzero(np.diff(share.indptr))
        to_field = section.of_strain[some].reshape(len(some), -1, section.of_strain.shape[3])
        yield _Part(rows, share[rows], section.arrays.of(some), to_field)


def _pair_strains(form: FloatArray, gradients: FloatArray) -> Iterator[tuple[slice, FloatArray]]:
    """For each j, positions of the pairs (j, k), k >= j, among all pairs, and their strain (E, g, s, r - j).

    form : (s, d, d), or (E, g, s, d, d), bilinear form of the nonlinear strain
    gradients : (E, g, d, r), of the basis columns
    """
    r, start = gradients.shape[-1], 0
    one_form = form.ndim == 3
    for j in range(r):
        first = gradients[..., j]
        along = np.tensordot(first, form, axes=(2, 1)) if one_form else first[:, :, None, None] @ form
        strains = along.reshape(*first.shape[:2], -1, first.shape[2]) @ gradients[..., j:]
        strains[..., 0] *= 0.5
        yield slice(start, start + r - j), strains
        start += r - j


def _times(modes: FloatArray, amplitudes: FloatArray) -> FloatArray:
    """Sum of modes (N, l, 6, m) times amplitudes (t, m): (t, N, l, 6)."""
    return (amplitudes @ modes.reshape(-1, modes.shape[-1]).T).reshape(-1, *modes.shape[:-1])

"""Stress and strain at nodes of a body's elements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from supple.arguments import check_fields
from supple.arrays import FloatArray, IntArray
from supple.body import BodyForm
from supple.body.floating_kinematics import checked_nodes
from supple.errors import ModelError
from supple.fem import FiniteElementModel, stress_layers, stress_recovery, von_mises, von_mises_strain
from supple.integrate import FramedMotion, Solution
from supple.machine import System
from supple.quantities.over_nodes import Maximum, Mean, MeasuredBlock, OverNodes
from supple.quantities.place import body_named
from supple.quantities.reading import Channel, Located, QuantityKind, point_words
from supple.quantities.stress_history import has_modes, tensor_blocks
from supple.quantities.tensor_modes import (
    STRAIN,
    STRESS,
    NodalTensor,
    TensorModes,
    principal_values,
    tensor_modes,
)

__all__ = ["Component", "Principal", "StrainSensor", "StressSensor", "TensorMeasure", "VonMises"]

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")


class TensorMeasure(Protocol):
    """Scalar measures of a symmetric tensor."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the k measures."""
        ...

    def of_stress(self, tensors: FloatArray) -> FloatArray:
        """Measures (..., k) from stresses (..., 6), components xx yy zz yz xz xy."""
        ...

    def of_strain(self, tensors: FloatArray) -> FloatArray:
        """Measures (..., k) from strains (..., 6) with engineering shear strains, same order."""
        ...


@dataclass(frozen=True)
class VonMises:
    """The von Mises equivalent, never negative."""

    names: tuple[str, ...] = field(default=("von Mises",), init=False)

    def of_stress(self, tensors: FloatArray) -> FloatArray:
        """sqrt(3/2 s:s), with the stress deviator s."""
        return von_mises(tensors)[..., None]

    def of_strain(self, tensors: FloatArray) -> FloatArray:
        """sqrt(2/3 e:e), with the strain deviator e."""
        return von_mises_strain(tensors)[..., None]


@dataclass(frozen=True)
class Component:
    """One component in the body's axes, with its sign: xx, yy, zz, yz, xz or xy."""

    name: str

    def __post_init__(self) -> None:
        if self.name not in COMPONENTS:
            raise ModelError(f"there is no component '{self.name}' of a tensor; use {', '.join(COMPONENTS)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Name of the component."""
        return (self.name,)

    def of_stress(self, tensors: FloatArray) -> FloatArray:
        """The component."""
        return tensors[..., [COMPONENTS.index(self.name)]]

    def of_strain(self, tensors: FloatArray) -> FloatArray:
        """The component; for a shear the engineering strain."""
        return self.of_stress(tensors)


@dataclass(frozen=True)
class Principal:
    """The three principal values, the largest first."""

    names: tuple[str, ...] = field(default=("first", "second", "third"), init=False)

    def of_stress(self, tensors: FloatArray) -> FloatArray:
        """Eigenvalues of the stress tensor, the largest first."""
        return principal_values(tensors)[..., ::-1]

    def of_strain(self, tensors: FloatArray) -> FloatArray:
        """Eigenvalues of the strain tensor, the largest first."""
        return self.of_stress(tensors * [1.0, 1.0, 1.0, 0.5, 0.5, 0.5])


@dataclass(frozen=True, eq=False)
class _TensorSensor(ABC):
    """A tensor at nodes of a body, averaged over the elements at each node; in a shell, at three layers.

    As a quantity of interest: the measure at each of the nodes, in the layer of largest magnitude.
    """

    name: str
    body: str
    model: FiniteElementModel
    nodes: int | Sequence[int] | IntArray
    measure: TensorMeasure = field(default_factory=VonMises)
    over: OverNodes = field(default_factory=Maximum)
    _modes: WeakKeyDictionary[BodyForm, TensorModes] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False
    )

    quantity: ClassVar[QuantityKind]
    tensor: ClassVar[NodalTensor]

    def __post_init__(self) -> None:
        check_fields(self)

    def channels(self, system: System) -> Sequence[Channel]:
        """One per value of the measure and per layer that any of the nodes has (`StressLayers`)."""
        _elastic(system, self.body, self.name)
        names, axes, place = stress_layers(self.model).names, f"axes of {self.body}", self._place()
        return [
            Channel(f"{names[layer]} {value}".strip(), self.quantity, axes, place)
            for layer in self._layers()
            for value in self.measure.names
        ]

    def values(self, system: System, solution: Solution) -> FloatArray:
        """Values (t, l k) of k measures in l layers, layer by layer."""
        return self.located(system, solution).values

    def located(self, system: System, solution: Solution) -> Located:
        """Values (t, l k), layer by layer, with the ids and undeformed positions of their nodes."""
        form, mesh, chosen = _elastic(system, self.body, self.name), self.model.mesh, self._chosen()
        coordinates, layers = solution.motion(self.body, FramedMotion).coordinates, self._layers()
        blocks = (
            MeasuredBlock(times, nodes, self._measured(field[:, :, layers]).reshape(*field.shape[:2], -1))
            for times, nodes, field in tensor_blocks(self.tensor, form, self.model, coordinates, chosen)
        )
        n_channels = len(layers) * len(self.measure.names)
        values, at = self.over.combined(blocks, (len(coordinates), len(chosen), n_channels))
        if at is None:
            return Located(values, None, None)
        return Located(values, mesh.node_ids[chosen[at]], mesh.nodes[chosen[at]])

    @property
    def words(self) -> str:
        """Description of the quantity and its norm."""
        return f"{' and '.join(self.measure.names)} {self.name}: RMS over its nodes, largest over the run"

    def at_points(self, system: System, solution: Solution) -> FloatArray:
        """The measure (t, N, k) at each node, in the layer of largest magnitude."""
        form, chosen = _elastic(system, self.body, self.name), self._chosen()
        coordinates = solution.motion(self.body, FramedMotion).coordinates
        if has_modes(form):
            if form not in self._modes:
                self._modes[form] = tensor_modes(self.tensor, form, self.model, chosen)
            found = self._measured(self._modes[form].at(coordinates))
        else:
            blocks = tensor_blocks(self.tensor, form, self.model, coordinates, chosen)
            found = np.concatenate([self._measured(field) for _, _, field in blocks])
        largest = np.abs(found).argmax(axis=2)
        return np.take_along_axis(found, largest[:, :, None], axis=2)[:, :, 0]

    def size(self, system: System, solution: Solution) -> float:
        """Largest magnitude of the measure over nodes and times."""
        return float(np.abs(self.at_points(system, solution)).max())

    @abstractmethod
    def _measured(self, tensors: FloatArray) -> FloatArray:
        """Measure (..., k) of tensors (..., 6)."""

    def _numbers(self) -> IntArray:
        try:
            numbers = checked_nodes(self.nodes, self.model.mesh.n_nodes)
        except (ModelError, TypeError, ValueError) as error:
            raise ModelError(f"sensor '{self.name}': nodes {self.nodes!r}: {error}") from None
        if not numbers.size:
            raise ModelError(f"sensor '{self.name}' has no node; give one or several")
        return numbers

    def _chosen(self) -> IntArray:
        """Numbers of the nodes to be read."""
        given = self._numbers()
        return given[self.over.read(self.model.mesh.nodes[given])]

    def _layers(self) -> IntArray:
        """Layers of the nodes; ModelError for a mean over nodes with different layers."""
        chosen = self._chosen()
        try:
            there = stress_recovery(self.model).around(chosen).layers_at(chosen)
        except ModelError as error:
            raise ModelError(f"sensor '{self.name}': {error}") from None
        if isinstance(self.over, Mean) and not (there.all(axis=0) | ~there.any(axis=0)).all():
            raise ModelError(
                f"sensor '{self.name}': its nodes belong to different kinds of elements, or to different "
                "numbers of beams, whose stresses have no common mean; use fewer nodes, or Maximum()"
            )
        return np.flatnonzero(there.any(axis=0))

    def _place(self) -> str:
        mesh, given, chosen = self.model.mesh, self._numbers(), self._chosen()
        of_how_many = f"{self.over.words} of {len(given)} nodes" if len(given) > 1 else ""
        if len(chosen) > 1:
            return of_how_many
        one = point_words(int(mesh.node_ids[chosen[0]]), mesh.nodes[chosen[0]])
        return f"{one}, {of_how_many}" if of_how_many else one


class StressSensor(_TensorSensor):
    """Stress at nodes of a body, averaged over the elements at each node; in a shell, at bottom, middle and
    top. In a beam, it is the stress at the points of the section, not averaged over the beams at a node.

    body : name of the body;   model : finite elements of the body
    nodes : number of one node, or of several nodes
    measure : VonMises(), Component("xx"), Principal() or a user-defined measure
    over : for several nodes the Maximum() of magnitude, the Mean(), or Nearest(), the node nearest to their
        centroid
    """

    quantity, tensor = QuantityKind.STRESS, STRESS

    def _measured(self, tensors: FloatArray) -> FloatArray:
        return self.measure.of_stress(tensors)


class StrainSensor(_TensorSensor):
    """Strain at nodes of a body, as a strain gauge would measure it; arguments as for `StressSensor`."""

    quantity, tensor = QuantityKind.STRAIN, STRAIN

    def _measured(self, tensors: FloatArray) -> FloatArray:
        return self.measure.of_strain(tensors)


def _elastic(system: System, body: str, sensor: str) -> BodyForm:
    form = body_named(system, body, sensor)
    if not form.n_coordinates:
        raise ModelError(f"sensor '{sensor}': body '{body}' is {form.kind}: it has no stress")
    if not form.has_frame:
        raise ModelError(
            f"sensor '{sensor}': body '{body}' has explicit finite elements, whose von Mises stress "
            f"is stored with their motion: use solution.bodies['{body}'].von_mises"
        )
    return form

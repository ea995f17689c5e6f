"""Stress and strain at nodes of a body's elements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from supple.body import FullBody
from supple.errors import ModelError
from supple.fem import FiniteElementModel, stress_recovery, von_mises, von_mises_strain
from supple.integrate import Solution
from supple.intrinsic import IntrinsicBody
from supple.machine import System
from supple.reduction import ReducedBody
from supple.results.stress_history import strain_history, stress_history
from supple.sensors.end_motion import body_named
from supple.sensors.reading import Channel, Quantity

__all__ = ["Component", "Principal", "StrainSensor", "StressSensor", "TensorMeasure", "VonMises"]

Array = NDArray[np.float64]
ElasticForm: TypeAlias = ReducedBody | FullBody | IntrinsicBody
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
_LAYERS = ("bottom", "middle", "top")


class TensorMeasure(Protocol):
    """Numbers that are read off a symmetric tensor."""

    @property
    def names(self) -> tuple[str, ...]:
        """What its numbers are called."""
        ...

    def of_stress(self, tensors: Array) -> Array:
        """(..., k) of stresses (..., 6), xx yy zz yz xz xy."""
        ...

    def of_strain(self, tensors: Array) -> Array:
        """(..., k) of strains (..., 6) with engineering shears."""
        ...


@dataclass(frozen=True)
class VonMises:
    """The equivalent of von Mises, never negative."""

    names: tuple[str, ...] = field(default=("von Mises",), init=False)

    def of_stress(self, tensors: Array) -> Array:
        """sqrt(3/2 s:s)."""
        return von_mises(tensors)[..., None]

    def of_strain(self, tensors: Array) -> Array:
        """sqrt(2/3 e:e)."""
        return von_mises_strain(tensors)[..., None]


@dataclass(frozen=True)
class Component:
    """One component in the body's axes, with its sign: xx, yy, zz, yz, xz or xy."""

    name: str

    def __post_init__(self) -> None:
        if self.name not in COMPONENTS:
            raise ModelError(f"there is no component '{self.name}' of a tensor: {', '.join(COMPONENTS)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Its own."""
        return (self.name,)

    def of_stress(self, tensors: Array) -> Array:
        """The component."""
        return tensors[..., [COMPONENTS.index(self.name)]]

    def of_strain(self, tensors: Array) -> Array:
        """The component; a shear is the engineering one."""
        return self.of_stress(tensors)


@dataclass(frozen=True)
class Principal:
    """The three principal values, the largest first."""

    names: tuple[str, ...] = field(default=("first", "second", "third"), init=False)

    def of_stress(self, tensors: Array) -> Array:
        """Eigenvalues."""
        xx, yy, zz, yz, xz, xy = np.moveaxis(tensors, -1, 0)
        full = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*xx.shape, 3, 3)
        return np.linalg.eigvalsh(full)[..., ::-1]

    def of_strain(self, tensors: Array) -> Array:
        """Eigenvalues."""
        return self.of_stress(tensors * [1.0, 1.0, 1.0, 0.5, 0.5, 0.5])


@dataclass(frozen=True, eq=False)
class _TensorSensor(ABC):
    """A tensor at a node of a body, averaged over its elements; of a shell at its bottom, middle and top."""

    name: str
    body: str
    model: FiniteElementModel
    node: int
    measure: TensorMeasure = field(default_factory=VonMises)

    quantity: ClassVar[Quantity]

    def channels(self, system: System) -> Sequence[Channel]:
        """One per value of the measure, and per layer of a shell."""
        _elastic(system, self.body, self.name)
        layers = _LAYERS if stress_recovery(self.model).n_layers > 1 else ("",)
        axes = f"axes of {self.body}"
        return [
            Channel(f"{layer} {value}".strip(), self.quantity, axes)
            for layer in layers
            for value in self.measure.names
        ]

    def values(self, system: System, solution: Solution) -> Array:
        """(t, l k), layer by layer."""
        form = _elastic(system, self.body, self.name)
        numbers = self._measured(form, solution.bodies[self.body].coordinates)
        return numbers.reshape(len(numbers), -1)

    @abstractmethod
    def _measured(self, form: ElasticForm, coordinates: Array) -> Array:
        """(t, 1, l, k)."""


class StressSensor(_TensorSensor):
    """Stress at a node of a body, averaged over its elements; of a shell at its bottom, middle and top.

    body : its name;   model : its elements
    node : its number
    measure : VonMises(), Component("xx"), Principal() or one of your own
    """

    quantity = Quantity.STRESS

    def _measured(self, form: ElasticForm, coordinates: Array) -> Array:
        return self.measure.of_stress(stress_history(form, self.model, coordinates, [self.node]))


class StrainSensor(_TensorSensor):
    """Strain at a node of a body: as a `StressSensor`, such as a strain gauge reads."""

    quantity = Quantity.STRAIN

    def _measured(self, form: ElasticForm, coordinates: Array) -> Array:
        return self.measure.of_strain(strain_history(form, self.model, coordinates, [self.node]))


def _elastic(system: System, body: str, sensor: str) -> ElasticForm:
    form = body_named(system, body, sensor)
    if not isinstance(form, ReducedBody | FullBody | IntrinsicBody):
        raise ModelError(f"sensor '{sensor}': body '{body}' is {form.kind}: it has no stress")
    return form

"""Motions of a body over time: arrays with one row per output time, of one kind per form of a body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np

from supple.integrate.error_statement import ErrorStatement
from supple.optional_packages import optional_package
from supple.summary import Summarized, Summary

__all__ = ["FloatingMotion", "Motion", "StackedMotion", "motion_from_arrays", "register_motion"]


class Motion(Protocol):
    """What every motion offers, whatever the form of its body; `register_motion` makes it readable."""

    kind: ClassVar[str]
    """Written to result files, so that the right class is made of the arrays again."""

    def at(self, rows: slice | np.ndarray) -> Self:
        """The motion at some of its output times, by their numbers."""
        ...

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Arrays (t, ...) by name, from which `kind(**arrays)` makes the same motion."""
        ...


_M = TypeVar("_M", bound=type[Motion])
_KINDS: dict[str, type[Motion]] = {}


def register_motion(motion: _M) -> _M:
    """Class decorator: result files with motions of this `kind` can be read."""
    _KINDS[motion.kind] = motion
    return motion


def motion_from_arrays(kind: str, arrays: Mapping[str, np.ndarray]) -> Motion:
    """The motion of a kind from its arrays; KeyError for a kind that no imported method registers."""
    if kind not in _KINDS:
        raise KeyError(f"motions of kind '{kind}', which this supple does not know")
    return _KINDS[kind](**arrays)


@dataclass(frozen=True, repr=False)
class StackedMotion(Summarized):
    """A motion all of whose fields are arrays with one row per output time."""

    kind: ClassVar[str]
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    """Of a field, behind the time; ("axis",) of those that are not named."""

    def summary(self) -> Summary:
        """Of every array its shape and the largest size of a value."""
        arrays = self.arrays()
        n_times = len(next(iter(arrays.values())))
        rows = [
            (name, f"{' x '.join(map(str, array.shape))}, at most {np.abs(array).max(initial=0.0):.4g}")
            for name, array in arrays.items()
        ]
        return Summary(f"Motion ({self.kind}) at {n_times} times", rows)

    def at(self, rows: slice | np.ndarray) -> Self:
        """The motion at some of its output times, by their numbers."""
        return type(self)(**{name: array[rows] for name, array in self.arrays().items()})

    def arrays(self) -> dict[str, np.ndarray]:
        """The fields by name."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def to_xarray(self, times: np.ndarray) -> Any:
        """An `xarray.Dataset` of the fields over `time`.

        times : (t,), of the solution that the motion is of
        Raises MissingPackageError where xarray is not installed.
        """
        xarray = optional_package("xarray", "a data set", "xarray")
        variables = {
            name: (("time", *self.dimensions.get(name, ("axis",))), array)
            for name, array in self.arrays().items()
        }
        return xarray.Dataset(variables, coords={"time": times})


@register_motion
@dataclass(frozen=True, repr=False)
class FloatingMotion(StackedMotion):
    """Motion of one body's floating frame and of its deformation coordinates, one row per output time."""

    kind: ClassVar[str] = "floating"
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {
            "rotation": ("axis", "body_axis"),
            "coordinates": ("coordinate",),
            "coordinate_rates": ("coordinate",),
            "coordinate_accelerations": ("coordinate",),
        }
    )

    position: np.ndarray
    """(t, 3) frame origin, global components."""
    rotation: np.ndarray
    """(t, 3, 3) rotation matrix, body components to global ones."""
    coordinates: np.ndarray
    """(t, r) deformation coordinates: reduced ones, or the nodal ones of a full body."""
    velocity: np.ndarray
    """(t, 3) velocity of the frame origin, global components."""
    angular_velocity: np.ndarray
    """(t, 3) angular velocity of the frame, body components, rad/s."""
    coordinate_rates: np.ndarray
    """(t, r)."""
    acceleration: np.ndarray
    """(t, 3) acceleration of the frame origin, global components."""
    angular_acceleration: np.ndarray
    """(t, 3) rate of the angular velocity, body components."""
    coordinate_accelerations: np.ndarray
    """(t, r)."""
    error: ClassVar[ErrorStatement | None] = None
    """How wrong the motion is, where it was estimated; no array, and not in `arrays`."""

    def with_error(self, error: ErrorStatement | None) -> Self:
        """The same motion, which knows how wrong it is."""
        assessed = replace(self)
        object.__setattr__(assessed, "error", error)
        return assessed

    def at(self, rows: slice | np.ndarray) -> Self:
        """The motion at some of its output times, by their numbers; the error remains that of the whole."""
        part = super().at(rows)
        return part if self.error is None else part.with_error(self.error)

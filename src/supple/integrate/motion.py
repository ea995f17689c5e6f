"""Motion of a body over time: arrays with one row per output time, in a class for each form of body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any, ClassVar, Self, TypeVar

import numpy as np

from supple.errors import ModelError
from supple.integrate.error_statement import ErrorStatement
from supple.optional_packages import optional_package
from supple.summary import Summarized, Summary

__all__ = ["FloatingMotion", "FramedMotion", "Motion", "motion_from_arrays", "register_motion"]

_M = TypeVar("_M", bound="Motion")


@dataclass(frozen=True, repr=False)
class Motion(Summarized):
    """A motion of a body of any form: all fields are arrays with one row per output time."""

    kind: ClassVar[str]
    """Name in result files; `register_motion` makes motions of this kind readable."""
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({})
    """By field: names of its array axes after the time axis; ("axis",) for fields not listed."""

    def summary(self) -> Summary:
        """Shape and largest absolute value of every array."""
        arrays = self.arrays()
        n_times = len(next(iter(arrays.values())))
        rows = [
            (name, f"{' x '.join(map(str, array.shape))}, at most {np.abs(array).max(initial=0.0):.4g}")
            for name, array in arrays.items()
        ]
        return Summary(f"Motion ({self.kind}) at {n_times} times", rows)

    def at(self, rows: slice | np.ndarray) -> Self:
        """The motion at the output times with the indices `rows`."""
        return type(self)(**{name: array[rows] for name, array in self.arrays().items()})

    def arrays(self) -> dict[str, np.ndarray]:
        """The fields by name; `type(self)(**arrays)` creates the same motion."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def of_type(self, expected: type[_M], what: str = "body") -> _M:
        """The motion itself, if it is of the expected type.

        what : name of the body, for the error message
        Raises ModelError for a motion of another type.
        """
        if not isinstance(self, expected):
            raise ModelError(
                f"{what}: its motion is of type {type(self).__name__}, but {expected.__name__} is needed: "
                f"give a body of that form, or read the fields of this one: {', '.join(self.arrays())}"
            )
        return self

    def to_xarray(self, times: np.ndarray) -> Any:
        """An `xarray.Dataset` of the fields over `time`.

        times : (t,) output times of the solution that contains this motion
        Raises MissingPackageError where xarray is not installed.
        """
        xarray = optional_package("xarray", "a data set", "xarray")
        variables = {
            name: (("time", *self.dimensions.get(name, ("axis",))), array)
            for name, array in self.arrays().items()
        }
        return xarray.Dataset(variables, coords={"time": times})


_KINDS: dict[str, type[Motion]] = {}


def register_motion(motion: type[_M]) -> type[_M]:
    """Class decorator that makes motions of this `kind` readable from result files."""
    _KINDS[motion.kind] = motion
    return motion


def motion_from_arrays(kind: str, arrays: Mapping[str, np.ndarray]) -> Motion:
    """The motion of a kind from its arrays; KeyError for a kind that no imported method registers."""
    if kind not in _KINDS:
        raise KeyError(
            f"motions of kind '{kind}' are unknown to this version of supple: update it, or import the "
            "method that defines them"
        )
    return _KINDS[kind](**arrays)


@dataclass(frozen=True, repr=False)
class FramedMotion(Motion):
    """A motion of a body, floating or intrinsic, that deforms relative to moving axes."""

    position: np.ndarray
    """(t, 3) origin of the body's axes, global components."""
    rotation: np.ndarray
    """(t, 3, 3) rotation matrix, body components to global ones."""
    coordinates: np.ndarray
    """(t, r) deformation coordinates, defined by the form of the body."""
    velocity: np.ndarray
    """(t, 3) velocity of the origin, global components."""
    angular_velocity: np.ndarray
    """(t, 3) angular velocity of the axes, body components, rad/s."""


@register_motion
@dataclass(frozen=True, repr=False)
class FloatingMotion(FramedMotion):
    """Motion of a body's floating frame and of its deformation coordinates (reduced, nodal or none)."""

    kind: ClassVar[str] = "floating"
    dimensions: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {
            "rotation": ("axis", "body_axis"),
            "coordinates": ("coordinate",),
            "coordinate_rates": ("coordinate",),
            "coordinate_accelerations": ("coordinate",),
        }
    )

    coordinate_rates: np.ndarray
    """(t, r)."""
    acceleration: np.ndarray
    """(t, 3) acceleration of the frame origin, global components."""
    angular_acceleration: np.ndarray
    """(t, 3) rate of the angular velocity, body components."""
    coordinate_accelerations: np.ndarray
    """(t, r)."""
    error: ClassVar[ErrorStatement | None] = None
    """Error of the motion, None if not estimated; it is not an array and not included in `arrays`."""

    def with_error(self, error: ErrorStatement | None) -> Self:
        """A copy of the motion with the given error."""
        assessed = replace(self)
        object.__setattr__(assessed, "error", error)
        return assessed

    def at(self, rows: slice | np.ndarray) -> Self:
        """The motion at the output times with the indices `rows`, with the error of the whole motion."""
        part = super().at(rows)
        return part if self.error is None else part.with_error(self.error)

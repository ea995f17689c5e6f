"""windIO turbine files (.yaml): their entries, lists of numbers and distributions along a component."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self, TypeAlias

import numpy as np
import scipy  # its parts are imported when first used
import yaml

from supple.arrays import FloatArray
from supple.errors import ImportFormatError
from supple.importers.plain_number import number_of_word
from supple.importers.text_file import file_text

Tree: TypeAlias = "str | list[Tree] | dict[str, Tree]"
"""Entries of a YAML file, with words as text."""

# The compiled parser, if installed, reads the same words ten times as fast.
_LOADER: type[yaml.BaseLoader] = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


@dataclass(frozen=True)
class WindioFile:
    """A windIO file, or an entry of one."""

    path: Path
    tree: Tree

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """The file; ImportFormatError if it is missing or no YAML."""
        text = file_text(Path(path), "save it as YAML")
        try:
            # Scalars stay text: YAML 1.1 would convert 1_000, 1:30 and 010 to other numbers.
            return cls(Path(path), yaml.load(text, Loader=_LOADER))
        except (yaml.YAMLError, ValueError, RecursionError) as error:
            if isinstance(error, RecursionError) or "nesting depth" in str(error):
                raise ImportFormatError(
                    f"{path}: its lists and entries nest too deep to be read; is this a windIO turbine file?"
                ) from None
            raise ImportFormatError(f"{path}: not readable as YAML ({error}); save it again") from error

    def entry(self, *keys: str) -> Tree:
        """The value under nested keys; ImportFormatError without one."""
        value = self.tree
        for depth, key in enumerate(keys):
            if not isinstance(value, dict) or key not in value:
                there = ", ".join(map(str, value)) if isinstance(value, dict) else "no keys"
                raise ImportFormatError(
                    f"{self.path}: no entry {'.'.join(keys[: depth + 1])}; there are {there}; is this a "
                    "windIO turbine file, version 1 or 2?"
                )
            value = value[key]
        return value

    def has(self, *keys: str) -> bool:
        """Whether the entry under all keys but the last contains the last key."""
        above = self.entry(*keys[:-1])
        return isinstance(above, dict) and keys[-1] in above

    def listed(self, *keys: str) -> list[Tree]:
        """The list under nested keys; ImportFormatError for another value."""
        found = self.entry(*keys)
        if not isinstance(found, list):
            raise ImportFormatError(
                f"{self.path}: {'.'.join(keys)} is no list; is this a windIO turbine file?"
            )
        return found

    def numbers(self, *keys: str) -> FloatArray:
        """A list of numbers under nested keys."""
        return self.as_numbers(self.entry(*keys), ".".join(keys))

    def distribution(self, *keys: str) -> scipy.interpolate.PchipInterpolator:
        """A quantity over the position 0 .. 1, from its grid and values; NaN outside the grid."""
        grid, values = self.numbers(*keys, "grid"), self.numbers(*keys, "values")
        if grid.size != values.size or grid.size < 2 or (np.diff(grid) <= 0).any():
            raise ImportFormatError(
                f"{self.path}: {'.'.join(keys)} has {grid.size} grid points and {values.size} values; give "
                "as many of both, at least two, the grid ascending"
            )
        return self.blended(grid, values, ".".join(keys), extrapolate=False)

    def covering(self, grid: FloatArray, *keys: str) -> scipy.interpolate.PchipInterpolator:
        """The distribution under nested keys; ImportFormatError unless its range contains that of `grid`."""
        curve = self.distribution(*keys)
        if grid[0] < curve.x[0] or grid[-1] > curve.x[-1]:
            raise ImportFormatError(
                f"{self.path}: {'.'.join(keys)} is given from {curve.x[0]:g} to {curve.x[-1]:g}, "
                f"the sections from {grid[0]:g} to {grid[-1]:g}; extend its grid as far"
            )
        return curve

    def blended(
        self, grid: FloatArray, values: FloatArray, what: str, *, extrapolate: bool
    ) -> scipy.interpolate.PchipInterpolator:
        """PCHIP curve through values; ImportFormatError if numbers are so large that slopes are not finite.

        what : name of the quantity for messages;  extrapolate : False gives NaN outside the grid
        """
        try:
            with np.errstate(all="ignore"):
                return scipy.interpolate.PchipInterpolator(grid, values, extrapolate=extrapolate)
        except ValueError as error:
            raise ImportFormatError(
                f"{self.path}: no curve runs through {what} ({error}); check the size of its numbers"
            ) from error

    def as_numbers(self, values: Tree, what: str) -> FloatArray:
        """Numbers (n,) of a word or a list of words; ImportFormatError for other entries."""
        try:
            listed = values if isinstance(values, list) else [values]
            words = [word for word in listed if isinstance(word, str)]
            if len(words) < len(listed):
                raise ValueError(what)
            return np.array([number_of_word(word) for word in words])
        except ValueError as error:
            raise ImportFormatError(f"{self.path}: {what} holds entries that are not numbers") from error

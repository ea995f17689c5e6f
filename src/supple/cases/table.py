"""A table of a case file that stands for one object of the library."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from supple.importers.toml import CheckedTable


class Made(CheckedTable):
    """A table that stands for one object, whose parameters begin with the keys of the table, in order."""

    makes: ClassVar[Callable[..., Any]]
    """The class of the object."""
    chosen_by: ClassVar[tuple[str, ...]] = ("kind", "basis")
    """Keys that choose among tables; they are no parameters."""

    def build(self, *_: Any) -> Any:
        """The object; what other tables of the same choice need besides their keys does not matter."""
        keys = (key for key in type(self).model_fields if key not in self.chosen_by)
        return type(self).makes(*(getattr(self, key) for key in keys))

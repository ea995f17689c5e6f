"""An explicit case: a checked case file, and the system, the run and the options that it describes."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from supple.cases.case_inputs import inputs_of_case
from supple.cases.explicit.explicit_tables import ExplicitTables, files_named, places_named
from supple.cases.notify import Notify, silent
from supple.errors import CaseError
from supple.explicit import ExplicitOptions, ExplicitSystem
from supple.importers.toml import KeyPath, LineIndex, listed_mistakes, unknown
from supple.integrate import Run
from supple.mesh import Mesh
from supple.storage.run_inputs import Inputs
from supple.units import UnitSystem

__all__ = ["ExplicitCase"]


@dataclass(frozen=True, eq=False)
class ExplicitCase:
    """A checked case file of an explicit run. What it describes is read and built once, when asked for.

    path : Path                 of the file; the files it names are relative to it
    text : str                  what stands in it
    tables : ExplicitTables     the same, checked
    lines : LineIndex           the way back from a table to its line
    notify                      hears of each long step of the build as it begins
    """

    path: Path
    text: str = field(repr=False)
    tables: ExplicitTables = field(repr=False)
    lines: LineIndex = field(repr=False)
    notify: Notify = field(default=silent, repr=False)

    @property
    def title(self) -> str:
        """One line for tables and pictures."""
        return self.tables.title

    @property
    def units(self) -> UnitSystem:
        """What its numbers are in, as far as it says so."""
        return UnitSystem.stated(self.tables.units)

    @property
    def folder(self) -> Path:
        """Where the file lies, and those it names."""
        return self.path.parent

    @property
    def files(self) -> tuple[str, ...]:
        """Names of the files that it reads."""
        return tuple(name for _, name in files_named(tomllib.loads(self.text)) if isinstance(name, str))

    @property
    def inputs(self) -> Inputs:
        """All that the motion depends on, by name: keys of the case, digests of its files as they are now.

        Raises
        ------
        CaseError   a file that cannot be read
        """
        return inputs_of_case(self.tables, self.files, self.folder)

    def error(self, mistakes: Iterable[tuple[KeyPath, str]]) -> CaseError:
        """One error that lists mistakes found after reading, such as a node set missing in a mesh."""
        return CaseError(listed_mistakes(self.path, self.lines, mistakes))

    @cached_property
    def run(self) -> Run:
        """The span of time."""
        return self.tables.simulation.build()

    @property
    def options(self) -> ExplicitOptions:
        """How it steps."""
        return self.tables.simulation.options()

    @cached_property
    def meshes(self) -> Mapping[str, Mesh]:
        """The mesh of each part, by its name.

        Raises
        ------
        CaseError   node sets that no mesh has: all, with their lines
        """
        self.notify("reading meshes")
        meshes = {part.name: part.read(self.folder) for part in self.tables.part}
        mistakes = []
        for path, place in places_named(tomllib.loads(self.text)):
            name, _, nodes = str(place).partition(".")
            if nodes not in meshes[name].node_sets:
                mistakes.append((path, unknown(f"node set of {name!r}", nodes, list(meshes[name].node_sets))))
        for number, part in enumerate(self.tables.part):
            for place, nodes in enumerate(part.modal.interfaces if part.modal else ()):
                if nodes not in meshes[part.name].node_sets:
                    known = list(meshes[part.name].node_sets)
                    path = ("part", number, "modal", "interfaces", place)
                    mistakes.append((path, unknown(f"node set of {part.name!r}", nodes, known)))
        if mistakes:
            raise self.error(mistakes)
        return meshes

    @cached_property
    def system(self) -> ExplicitSystem:
        """The parts with what ties, holds, hits and loads them.

        Raises
        ------
        CaseError    as for `meshes`
        SuppleError  whatever meshes, elements, modes and ties find wrong
        """
        tables, meshes = self.tables, self.meshes
        parts = []
        for part in tables.part:
            self.notify(f"{'reducing' if part.modal else 'assembling'} part '{part.name}'")
            parts.append(part.build(meshes[part.name]))
        return ExplicitSystem(
            parts,
            ties=[tie.build() for tie in tables.tie],
            contacts=[contact.build() for contact in tables.contact],
            supports=[support.build() for support in tables.support],
            forces=[load.build(self.folder) for load in tables.load],
            gravity=np.array(tables.gravity),
        )

"""A case: a checked case file, with its system, run and meshes."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from supple.arrays import IntArray
from supple.body import BodyForm, BodySource, FlexibleBody, FullBody, section_beams
from supple.cases.bodies import Body, checked_line
from supple.cases.case_inputs import inputs_of_case
from supple.cases.case_tables import CaseTables, files_named, places_named
from supple.cases.control import check_code_allowed, controllers_of
from supple.cases.notify import Notify, silent
from supple.cases.reductions import reduction_start
from supple.cases.sensors import SensedCase
from supple.cases.split import SplitSource, pressed_triangles, split_source
from supple.cases.split_tables import base_of, changed_frequencies, with_damping, with_parts
from supple.cases.stated_error import OfInterest
from supple.error import ErrorStudy, ReductionStart
from supple.errors import CaseError, ModelError, SuppleError
from supple.fem import FiniteElementModel, cells_without_stress, stress_recovery
from supple.importers import read_section_table
from supple.importers.toml import KeyPath, LineIndex, listed_mistakes, nearest_hint
from supple.integrate import Run
from supple.machine import At, ForceElement, NodalLoad, SplitBody, System
from supple.mesh import CellType, Mesh
from supple.mesh.outer_faces import outer_triangles
from supple.quantities import Place, Quantity, QuantityOfInterest
from supple.reduction import BodyModes, body_modes
from supple.results.run_summary import N_DRAWN_MODES
from supple.simulation.full_rest import known_fulls
from supple.storage.run_inputs import FILE, Inputs
from supple.units import UnitSystem

__all__ = ["Case"]


@dataclass(frozen=True, eq=False)
class Case:
    """A checked case file. Its parts are read and built once, on first use.

    path : Path             path of the file; file names in it are relative to its folder
    tables : CaseTables     checked content of the file
    lines : LineIndex       line of each table
    notify                  called at each long step of the build, with its progress
    made : Mapping          bodies that are built already, by name: a sweep reduces each body once
    """

    path: Path
    text: str = field(repr=False)
    tables: CaseTables = field(repr=False)
    lines: LineIndex = field(repr=False)
    notify: Notify = field(default=silent, repr=False)
    made: Mapping[str, BodyForm] = field(default_factory=dict, repr=False)

    def varied(self, tables: CaseTables, made: Mapping[str, BodyForm]) -> Case:
        """The case with other tables and bodies that are built already; meshes are not read again."""
        other = replace(self, tables=tables, made=made)
        vars(other).update({name: vars(self)[name] for name in _OF_MESHES if name in vars(self)})
        return other

    @property
    def title(self) -> str:
        """One line for tables and pictures."""
        return self.tables.title

    @property
    def units(self) -> UnitSystem:
        """The units that the case states."""
        return UnitSystem.stated(self.tables.units)

    @property
    def folder(self) -> Path:
        """Folder of the case file, to which its file names are relative."""
        return self.path.parent

    @property
    def made_here(self) -> frozenset[str]:
        """Names of the bodies that the case builds, without those read from files of reduced bodies."""
        return frozenset(body.name for body in self.parts.body if body.reduced is None)

    @property
    def files(self) -> tuple[str, ...]:
        """Names of the files that the case reads, as written in its tables."""
        given = self.tables.model_dump(mode="json")
        return tuple(name for _, name in files_named(given) if isinstance(name, str))

    @property
    def inputs(self) -> Inputs:
        """All inputs of the motion, by name: the keys of the case, and digests of its files as they are now.

        Raises
        ------
        CaseError   a file that cannot be read
        """
        return inputs_of_case(self.tables, self.files, self.folder)

    def place(self, text: str) -> Place:
        """The place that `BODY.PLACE` names: an interface of the body, or the nodes of a set of its mesh."""
        name, _, place = text.partition(".")
        body = next(table for table in self.parts.body if table.name == name)
        if place in [interface.name for interface in body.interface]:
            return Place(name, place)
        return Place(name, tuple(self.meshes[name].nodes_of(place).tolist()))

    def pressed(self, at: str) -> IntArray:
        """Triangles (T, 3) of outer faces, of a body or a part, with all corners in `BODY.NODE_SET`."""
        name, _, node_set = at.partition(".")
        for split in self._split.values():
            if name in split.parts:
                return pressed_triangles(split, name, node_set)
        return outer_triangles(self.meshes[name], self.meshes[name].nodes_of(node_set))

    def error(self, mistakes: Iterable[tuple[KeyPath, str]]) -> CaseError:
        """An error with all mistakes found after reading, such as a node set missing in a mesh."""
        return CaseError(listed_mistakes(self.path, self.lines, mistakes))

    @cached_property
    def run(self) -> Run:
        """The time span and the method of integration."""
        return self.tables.simulation.build()

    @cached_property
    def _whole(self) -> Mapping[str, BodySource]:
        """The source of each elastic body, before any is split.

        Raises
        ------
        CaseError   node sets of interfaces, loads or output that a mesh lacks: lists all, with their lines
        """
        self.notify("reading meshes")
        sources = {
            body.name: body.elastic.source(self.folder, body.mesh or "", body.cells)
            for body in self.tables.body
            if body.elastic is not None
        }
        mistakes = [
            (path, message)
            for path, body, name in self._node_sets_named()
            if body in sources and (message := _missing(name, sources[body].mesh))
        ]
        if mistakes:
            raise self.error(mistakes)
        return sources

    def names_in_machine(self, names: Sequence[str]) -> list[str]:
        """Names of bodies as in the machine: a split body is replaced by its parts."""
        parts = {name: list(split.parts) for name, split in self._split.items()}
        return [part for name in names for part in parts.get(name, [name])]

    @cached_property
    def _split(self) -> Mapping[str, SplitSource]:
        """The parts of the bodies that are split, by the names of the bodies."""
        return {
            body.name: split_source(body.name, self._whole[body.name], body.split)
            for body in self.tables.body
            if body.split is not None
        }

    @cached_property
    def parts(self) -> CaseTables:
        """The tables of the case, with split bodies replaced by their parts.

        Raises
        ------
        CaseError    as for `sources`
        SuppleError  a body that cannot be split in this way
        """
        bodies = tuple(
            body if body.split is None else with_damping(body, self._unsplit[body.name])
            for body in self.tables.body
        )
        return with_parts(self.tables.model_copy(update={"body": bodies}), self._split)

    @cached_property
    def _unsplit(self) -> Mapping[str, FlexibleBody]:
        """The bodies to be split, before the split."""
        return {b.name: b.flexible(self._whole[b.name]) for b in self.tables.body if b.split is not None}

    @cached_property
    def sources(self) -> Mapping[str, BodySource]:
        """The source of each elastic body, by body name; split bodies are replaced by their parts.

        Raises
        ------
        CaseError   node sets of interfaces, loads or output that a mesh lacks: lists all, with their lines
        """
        parts = {name: source for split in self._split.values() for name, source in split.parts.items()}
        return {name: made for name, made in self._whole.items() if name not in self._split} | parts

    @cached_property
    def meshes(self) -> Mapping[str, Mesh]:
        """The mesh of each body that has elements, by body name."""
        return {name: source.mesh for name, source in self.sources.items() if source.mesh is not None}

    @cached_property
    def elements(self) -> Mapping[str, FiniteElementModel]:
        """The elements of each body with elements, by body name; also of linear bodies."""
        return {name: source.model() for name, source in self.sources.items() if source.model is not None}

    @cached_property
    def flexible(self) -> Mapping[str, FlexibleBody]:
        """The elastic bodies built by the case, before reduction, by body name.

        Raises
        ------
        CaseError    as for `sources`
        SuppleError  a model that fails its check; the message lists all findings
        """
        flexible = {}
        for table in self.parts.body:
            if table.name in self.sources and table.explicit is None:
                self.notify(f"assembling body '{table.name}'")
                flexible[table.name] = table.flexible(self.sources[table.name])
                self.notify(checked_line(flexible[table.name]))
        for name, whole in self._unsplit.items():
            parts = tuple(flexible[part] for part in self._split[name].parts)
            self.notify(changed_frequencies(whole, SplitBody(name, self._split[name].mesh, parts)))
        return flexible

    @cached_property
    def bases(self) -> Mapping[str, At]:
        """Reference of deflections, by name of a part: the first interface of the undivided body."""
        found = {}
        for body in self.tables.body:
            base = base_of(body, self._split[body.name]) if body.split is not None else None
            if base is not None:
                found |= dict.fromkeys(self._split[body.name].parts, base)
        return found

    @cached_property
    def system(self) -> System:
        """The bodies, reduced if their reduction has a fixed size, with joints, loads, springs and elements.

        Controllers are not included, because they run code; `controlled` adds them.

        Raises
        ------
        CaseError    as for `sources`; colour = "von-mises" for bodies without stress
        SuppleError  errors of meshes, bodies, reductions and joints
        """
        tables = self.parts
        if tables.output.colour == "von-mises":
            self._check_stress()
        bodies = []
        for table in tables.body:
            if table.name in self.made:
                bodies.append(table.placed(self.made[table.name]))
                continue
            model = None if table.explicit is None else self.elements[table.name]
            bodies.append(table.build(self.flexible.get(table.name), self.folder, self.notify, model))
        joints = [table.build(self.folder) for table in tables.joint]
        unloaded = System(tuple(bodies), tuple(joints), gravity=np.array(tables.gravity))
        loads = [table.build(self.folder, self.place, self.pressed) for table in tables.load]
        for load in loads:
            if isinstance(load, NodalLoad) and load.body in self.flexible:
                self.flexible[load.body].warn_of_massless(load.label, load.nodes)
        forces = [table.build(self.folder) for table in (*tables.spring, *tables.element)]
        frictions = [
            table.friction.build(joint)
            for table, joint in zip(tables.joint, joints, strict=True)
            if table.friction is not None
        ]
        return replace(
            unloaded,
            loads=(*loads, *forces, *frictions),
            ties=[table.build() for table in tables.tie],
            contacts=[table.build() for table in tables.contact],
            supports=[table.build() for table in tables.support],
        )

    def check_control(self, *, allow_code: bool) -> None:
        """Raise CaseError, before any computation, for controllers that are not allowed or cannot be used."""
        control = self.tables.control
        check_code_allowed(control, allow_code=allow_code)
        if control is not None and self.starts:
            raise CaseError(
                f"{self.path}: body '{next(iter(self.starts))}' is reduced to an accuracy, but errors are "
                "not estimated with a controller: give it a basis of fixed size (remove accuracy), or "
                "remove control"
            )

    def controlled(self, system: System, *, allow_code: bool) -> System:
        """The system with the controllers of the case.

        Raises CaseError for code that is not allowed to run, or that fails.
        """
        made = controllers_of(self.tables.control, system, self.folder, allow_code=allow_code)
        return replace(system, controllers=made)

    @cached_property
    def starts(self) -> Mapping[str, ReductionStart]:
        """Start of each self-correcting reduction, by body; in `system` these bodies are not reduced."""
        found = {}
        for table in self.parts.body:
            if table.corrects_itself and table.name not in self.made:
                accuracy = getattr(table.reduction, "accuracy", None)
                of = None if accuracy is None or accuracy.of is None else self._quantity(accuracy.of)
                found[table.name] = reduction_start(table.reduction, self.flexible[table.name], of)
        return found

    def _quantity(self, table: OfInterest) -> QuantityOfInterest:
        return table.quantity(self.place, self.elements)

    def named_elements(self, system: System) -> dict[str, ForceElement]:
        """The springs and force elements of the case that have a name, in its machine, by name."""
        # Friction of joints follows the elements in the loads, and has no name.
        tables = (*self.parts.spring, *self.parts.element)
        named = zip(tables, system.loads[len(self.parts.load) :], strict=False)
        return {
            table.name: element
            for table, element in named
            if table.name is not None and isinstance(element, ForceElement)
        }

    @cached_property
    def sensors(self) -> tuple[Quantity, ...]:
        """The sensors, which are evaluated after the run.

        Raises
        ------
        CaseError   as for `sources`; errors of sensors, each with its line
        """
        sensed = SensedCase(self.place, self.bases, self.elements, self.named_elements(self.system))
        made, mistakes = [], []
        for number, table in enumerate(self.parts.sensor):
            try:
                sensor = table.build(sensed)
                sensor.channels(self.system)
                made.append(sensor)
            except SuppleError as error:
                mistakes.append((("sensor", number), str(error)))
        if mistakes:
            raise self.error(mistakes)
        return tuple(made)

    @cached_property
    def study(self) -> ErrorStudy:
        """The parts of the error to estimate, and the quantities of interest.

        The error of bases of fixed size is estimated on request only. So is the integration error if a body
        is not reduced. Its estimate needs two more runs, each of which costs as much as the first run.
        """
        given = self.parts.error
        in_full = any(name not in self.starts for name in self.system.bodies_of(FullBody))
        return ErrorStudy(
            basis=bool(given.basis),
            integration=not in_full if given.integration is None else given.integration,
            model=given.model,
            quantities=tuple(self._quantity(each) for each in given.of),
        )

    @cached_property
    def fulls(self) -> Mapping[str, FullBody]:
        """The bodies in a floating frame that the case builds, before reduction, by name."""
        return known_fulls(self.system) | self.system.bodies_of(FullBody)

    @cached_property
    def held_modes(self) -> Mapping[str, BodyModes]:
        """Modes of each body before reduction, by name, with its first interface clamped.

        A body without interfaces has the constraint of its frame instead.
        """
        found = {}
        for name, full in self.fulls.items():
            held = full.interfaces[0].motion if full.interfaces else full.frame.constraint(full.body)
            found[name] = body_modes(full.body, held, n_modes=N_DRAWN_MODES)
        return found

    @cached_property
    def drawn(self) -> Mapping[str, Mesh | FiniteElementModel | None]:
        """Geometry for drawing each body, by name: mesh; None: drawn as points.

        Elements instead of the mesh if the body has beams, or cells without stress, which are drawn plain.
        """
        found: dict[str, Mesh | FiniteElementModel | None] = {
            table.name: self._beams_of_line(table)
            for table in self.parts.body
            if table.name not in self.meshes
        }
        for name, mesh in self.meshes.items():
            model = self.elements.get(name)
            if model is not None and (CellType.LINE2 in mesh.cells or cells_without_stress(model)):
                found[name] = model
            elif any(kind.dimension > 1 for kind in mesh.cells):
                found[name] = mesh
        return found

    def _beams_of_line(self, body: Body) -> FiniteElementModel | None:
        """Beams between the stations of a line from a section table, to draw them; None for other bodies."""
        stations = None if body.condense is None else body.condense.stations
        if body.section_table is None or stations is None:
            return None
        return section_beams(read_section_table(self.folder / body.section_table), stations - 1)

    @property
    def page_looks(self) -> Mapping[str, Mesh | FiniteElementModel]:
        """Geometry of the bodies in a report, as in pictures, but with lines for beams of unknown section."""
        return {**self.meshes, **{name: look for name, look in self.drawn.items() if look is not None}}

    @property
    def exported_meshes(self) -> Mapping[str, Mesh]:
        """Meshes in files for ParaView: also the beams between the stations of a line."""
        lines = {name: look for name, look in self.drawn.items() if name not in self.meshes}
        beams = {name: look.mesh for name, look in lines.items() if isinstance(look, FiniteElementModel)}
        return {**self.meshes, **beams}

    def coloured_elements(self, system: System) -> Mapping[str, FiniteElementModel] | None:
        """Elements whose stress colours bodies; None unless the case selects it or a body has no frame."""
        framed = all(placed.body.has_frame for placed in system.bodies)
        return self.elements if self.tables.output.colour == "von-mises" or not framed else None

    def texts(self, inputs: Inputs) -> dict[str, str]:
        """The text of the case file as it was read, and digests in `inputs` of the files that it names."""
        listed = [f"{name}  {value}" for name, value in inputs.items() if name.startswith(FILE)]
        return {self.path.name: self.text} | ({"files that it names": "\n".join(listed)} if listed else {})

    @property
    def track(self) -> dict[str, Place]:
        """The tracked places, by their names in the case."""
        return {name: self.place(name) for name in self.parts.output.track}

    def _check_stress(self) -> None:
        """Raise CaseError, before the run, if bodies to be coloured have no stress.

        Beam bodies without stress recovery points are drawn in plain colour if other bodies have stress.
        """
        mistakes, beams = [], []
        shown = [name for name, look in self.drawn.items() if look is not None and name in self.elements]
        for name in shown:
            try:
                stress_recovery(self.elements[name])
            except ModelError as error:
                alone = set(self.meshes[name].cells) == {CellType.LINE2}
                (beams if alone else mistakes).append(f"body '{name}': {error}; remove the key")
        if len(beams) == len(shown):
            mistakes += beams or ["there is no body with elements to colour; remove the key"]
        if mistakes:
            raise self.error((("output", "colour"), mistake) for mistake in mistakes)

    def _node_sets_named(self) -> Iterator[tuple[KeyPath, str, str]]:
        """All names of node sets: key path, body, set. Loads and output may name interfaces instead."""
        tables = self.tables
        for i, body in enumerate(tables.body):
            for j, interface in enumerate(body.interface):
                if interface.nodes is not None:
                    yield ("body", i, "interface", j, "nodes"), body.name, interface.nodes
        interfaces = {f"{body.name}.{interface.name}" for body in tables.body for interface in body.interface}
        for path, place, may_be in places_named(tomllib.loads(self.text)):
            if may_be == "node set" and isinstance(place, str) and place not in interfaces:
                body, _, name = place.partition(".")
                yield path, body, name


_OF_MESHES = ("_whole", "_split", "_unsplit", "sources", "meshes", "elements")
"""Cached properties that depend on the meshes, not on other numbers of the case."""


def _missing(name: str, mesh: Mesh | None) -> str:
    if mesh is None or name in mesh.node_sets:
        return ""
    known = ", ".join(mesh.node_sets) or "none"
    return f"there is no node set named {name!r}{nearest_hint(name, mesh.node_sets)}; the mesh has: {known}"

"""The whole case file: all its tables, and all its rules."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from pydantic import ConfigDict, Field

from supple.cases import (
    bodies,
    condense,
    contacts,
    control,
    elements,
    joints,
    loads,
    output,
    parameter_path,
    sensors,
    simulation,
    stated_error,
)
from supple.cases.bodies import Body
from supple.cases.body_kinds import place_exists
from supple.cases.contacts import ContactTable, SupportTable, TieTable
from supple.cases.control import control_file
from supple.cases.elements import ElementTable, SpringTable
from supple.cases.joints import JointTable
from supple.cases.laws import tables_suit_the_run
from supple.cases.loads import Load
from supple.cases.machine_file import MachineFile
from supple.cases.output import Output
from supple.cases.parameter_path import ParameterTable
from supple.cases.sensors import Sensor
from supple.cases.simulation import Simulation, SpinTable
from supple.cases.stated_error import StatedError
from supple.cases.table import named_in
from supple.errors import ModelError
from supple.importers.text_file import is_file
from supple.importers.toml import ZERO, CheckedTable, KeyPath, Mistakes, Raw, Rule, Vector
from supple.units import UnitSystem

_PARTS_ARE_BODIES = (
    '[[part]] is now [[body]]: rename these tables; modal = {modes = M, interfaces = ["A"]} becomes modal = '
    '{modes = M} with interface = [{name = "A", kind = "averaging", nodes = "A"}]; angular_velocity is along '
    'the axes of the body; a [[load]] needs kind = "force"; safety, largest_ratio, interface_loss and scheme '
    "are keys of [simulation] explicit = {..}; [output] colour is one word"
)


class CaseTables(CheckedTable):
    """A whole case file."""

    model_config = ConfigDict(json_schema_extra={"renamed": {"part": _PARTS_ARE_BODIES}})

    title: str = Field(description="one line for tables and pictures")
    gravity: Vector = Field(ZERO, description="global axes, an acceleration")
    units: dict[str, str] = Field(
        default_factory=dict,
        description='such as { length = "mm", mass = "t", time = "s" }; numbers are not converted',
    )
    machine: MachineFile | None = None
    body: Annotated[tuple[Body, ...], Field(strict=False)]
    joint: Annotated[tuple[JointTable, ...], Field(strict=False)] = ()
    load: Annotated[tuple[Load, ...], Field(strict=False)] = ()
    spring: Annotated[tuple[SpringTable, ...], Field(strict=False)] = ()
    element: Annotated[tuple[ElementTable, ...], Field(strict=False)] = ()
    tie: Annotated[tuple[TieTable, ...], Field(strict=False)] = ()
    contact: Annotated[tuple[ContactTable, ...], Field(strict=False)] = ()
    support: Annotated[tuple[SupportTable, ...], Field(strict=False)] = ()
    control: str | None = Field(None, description="FILE.py:FUNCTION; runs with --allow-code")
    sensor: Annotated[tuple[Sensor, ...], Field(strict=False)] = ()
    parameter: Annotated[tuple[ParameterTable, ...], Field(strict=False)] = ()
    simulation: Simulation
    spin: SpinTable | None = None
    error: StatedError = Field(default_factory=StatedError)
    output: Output = Field(default_factory=Output)


def units_are_one_set(raw: Raw) -> Mistakes:
    """The rule that the units of a case agree."""
    units = raw.get("units", {})
    if not isinstance(units, dict) or not all(isinstance(unit, str) for unit in units.values()):
        return
    try:
        UnitSystem.stated(units)
    except ModelError as error:
        yield ("units",), str(error)


RULES: tuple[Rule, ...] = (
    *bodies.RULES,
    *joints.RULES,
    *condense.RULES,
    *loads.RULES,
    *elements.RULES,
    *contacts.RULES,
    *control.RULES,
    *simulation.RULES,
    *output.RULES,
    *stated_error.RULES,
    *sensors.RULES,
    *parameter_path.RULES,
    units_are_one_set,
)
"""Rules between keys, defined in the modules of the sections."""


def broken_rules(raw: Raw, folder: Path) -> list[tuple[KeyPath, str]]:
    """Every violated rule of a case: the path of its key, and the message with the remedy.

    Parameters
    ----------
    raw : mapping    the case as the TOML reader returns it
    folder : Path    folder of the case file, to which its file names are relative
    """
    broken = [mistake for rule in RULES for mistake in rule(raw)]
    broken += [mistake for place in places_named(raw) for mistake in place_exists(raw, *place)]
    return [*broken, *_files_exist(raw, folder), *tables_suit_the_run(raw, folder)]


def _files_exist(raw: Raw, folder: Path) -> Mistakes:
    for path, name in files_named(raw):
        if path[-1] == "reduced":
            continue  # `completed` in `read_case` reports it
        if isinstance(name, str) and not is_file(folder / name):
            yield path, f"there is no file {folder / name}; file names are relative to the case file"


def places_named(raw: Raw) -> Iterator[tuple[KeyPath, object, str]]:
    """Every key of a case with a place: path, value, and kind of place."""
    return (each for each in named_in(CaseTables, raw) if each[-1] != "file")


def files_named(raw: Raw) -> Iterator[tuple[KeyPath, object]]:
    """Every key of a case with a file name, and its value."""
    yield from ((path, name) for path, name, what in named_in(CaseTables, raw) if what == "file")
    yield ("control",), control_file(raw.get("control"))

"""Write the run in a result file for ParaView or as a table, or a mode of a case for ParaView."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supple.cases import read_case
from supple.cases.modes_case import mode_case
from supple.cases.result_machine import ResultMachine, result_machine
from supple.cases.result_tables import recorded_quantities
from supple.cases.run_files import check_not_an_input
from supple.cli.export import ExportOptions
from supple.errors import ArgumentError, ModelError, ResultFileError
from supple.export import TABLE_SUFFIXES, write_readings, write_vtkhdf, write_vtu
from supple.fem import FiniteElementModel, stress_recovery
from supple.quantities import QuantityKind, Readings, read_in_parts
from supple.simulation.stored_bodies import stored_path
from supple.storage import ResultParts
from supple.terminal import say, shown_step
from supple.units import with_unit

_PICTURES = (".vtkhdf", ".vtu")


def export_result(path: Path, target: Path, options: ExportOptions) -> None:
    """Write the run in the result file at `path`, in the format of the target's suffix.

    A .vtu has one time; for ParaView all bodies are written with the joints.

    Raises
    ------
    ArgumentError       invalid times
    ModelError          a target with another suffix; as for the writers
    ResultFileError     as for `result_machine`; a target that is the result or one of its reduced bodies, or
                        that cannot be written
    """
    suffix = target.suffix.lower()
    if suffix not in (*_PICTURES, *TABLE_SUFFIXES):
        known = ", ".join((*_PICTURES, *TABLE_SUFFIXES))
        raise ModelError(f"cannot write {target}: give a file that ends in {known}")
    with shown_step("reading") as notify:
        found = result_machine(path, options.case, notify)
        check_not_an_input(found.case, [target])
        bodies = {stored_path(path.parent, each.body.name).resolve() for each in found.system.bodies}
        if target.resolve() in {path.resolve(), *bodies}:
            raise ResultFileError(
                f"cannot write {target}: it is the result itself and would be lost; write another file (-o)"
            )
        rows = _rows(found.run.times, suffix, options)
        run = ResultParts(path, rows)
        notify("writing")
        if suffix in TABLE_SUFFIXES:
            write_readings(target, _readings(found, run), units=found.case.units)
        else:
            _write_picture(target, suffix, found, run, options)
    instants = f"{len(rows)} instants" if len(rows) > 1 else f"t = {run.times[0]:g}"
    say(f"{instants if len(rows) > 1 else with_unit(instants, found.case.units.time)} written to {target}")


def _readings(found: ResultMachine, run: ResultParts) -> Readings:
    """Readings of all quantities of a table at the output times of `run`.

    Angles are read at all output times of the file, to count the revolutions between the chosen times.
    """
    quantities = recorded_quantities(found.case, found.system)
    angles = [
        each
        for each in quantities
        if any(channel.quantity is QuantityKind.ANGLE for channel in each.channels(found.system))
    ]
    others = [each for each in quantities if each not in angles]
    made = {each.name: each for each in read_in_parts(others, found.system, run)}
    if angles:
        for each in read_in_parts(angles, found.system, ResultParts(run.path)):
            made[each.name] = replace(each, times=run.times, values=each.values[run.rows])
    return Readings(made[each.name] for each in quantities)


def _rows(there: NDArray[np.float64], suffix: str, options: ExportOptions) -> NDArray[np.int64]:
    """Indices of the output times nearest to the requested ones."""
    if suffix == ".vtu":
        wanted = np.array([there[-1] if options.time is None else options.time])
    elif options.times is not None:
        wanted = _spread(options.times)
    else:
        return np.arange(len(there))
    half = float(np.diff(there).max(initial=0.0)) / 2
    beyond = wanted[~((wanted >= there[0] - half) & (wanted <= there[-1] + half))]
    if beyond.size:
        raise ArgumentError(
            f"the run has no output at {beyond[0]:g}: give times from {there[0]:g} to {there[-1]:g}"
        )
    return np.unique(np.searchsorted((there[1:] + there[:-1]) / 2, wanted))


def _spread(times: str) -> NDArray[np.float64]:
    try:
        first, last, number = times.split(":")
        count = int(number)
        if count < 1:
            raise ValueError
        return np.linspace(float(first), float(last), count)
    except ValueError as error:
        raise ArgumentError(
            f"--times must be FROM:TO:NUMBER with a NUMBER of at least 1, such as 0:10:101, got {times}"
        ) from error


def _write_picture(
    target: Path, suffix: str, found: ResultMachine, run: ResultParts, options: ExportOptions
) -> None:
    case = found.case
    wanted = case.names_in_machine(options.body or ())
    of_picture: dict[str, Any] = {
        "elements": _with_stress(case.elements, wanted) if options.stress else {},
        "bodies": wanted or None,
        "bases": case.bases,
        "units": case.units,
    }
    if suffix == ".vtu":
        (instant,) = run
        write_vtu(target, found.system, instant, case.exported_meshes, **of_picture)
    else:
        write_vtkhdf(target, found.system, run, case.exported_meshes, **of_picture)


def _with_stress(
    elements: Mapping[str, FiniteElementModel], bodies: Sequence[str] | None
) -> dict[str, FiniteElementModel]:
    """The elements of the bodies that have stress; prints a line for each body without stress."""
    known = {}
    for name, model in elements.items():
        if bodies and name not in bodies:
            continue
        try:
            stress_recovery(model)
            known[name] = model
        except ModelError as error:
            say(f"no stress of body '{name}': {error}")
    return known


def export_mode(path: Path, target: Path, options: ExportOptions) -> None:
    """Write one period (.vtkhdf) or phase 0 (.vtu) of a mode of the machine of the case at `path`.

    Raises
    ------
    ArgumentError       not a case; another suffix
    ModelError          as `machine_modes` and the writers
    ResultFileError     a file that cannot be written
    """
    assert options.mode is not None
    suffix = target.suffix.lower()
    if path.suffix.lower() != ".toml" or suffix not in _PICTURES:
        raise ArgumentError("--mode needs a case (.toml) and a file .vtkhdf or .vtu")
    with shown_step("reading") as notify:
        case = read_case(path, notify)
        check_not_an_input(case, [target])
        system, motion = mode_case(case, options.mode, time=options.time or 0.0)
        write, shown = (write_vtu, motion.at(slice(1))) if suffix == ".vtu" else (write_vtkhdf, motion)
        bodies = case.names_in_machine(options.body or ()) or None
        write(target, system, shown, case.exported_meshes, bodies=bodies, bases=case.bases, units=case.units)
    say(f"mode {options.mode} written to {target}")

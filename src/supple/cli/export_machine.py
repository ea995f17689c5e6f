"""Write the machine of a case as C source, or as an FMU."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from supple.cases import Case, read_case
from supple.cases.case_family import case_family
from supple.cases.notify import Notify
from supple.cases.result_machine import result_machine
from supple.cases.run_files import check_not_an_input
from supple.cases.static_case import starting_system
from supple.cli.export import ExportOptions
from supple.errors import ArgumentError, CaseError, did_you_mean
from supple.export.c.machine_source import write_machine
from supple.export.fmu.platforms import PLATFORMS, Platform
from supple.export.fmu.write_fmu import write_fmu, write_linear_fmu
from supple.export.linear.linear_form import linear_form
from supple.machine import (
    AngleServo,
    Cylindrical,
    ForceBetween,
    ForceElement,
    Joint,
    PrescribedRotation,
    PrescribedTranslation,
    Prismatic,
    PrismaticFriction,
    Revolute,
    RevoluteFriction,
    SlideServo,
    System,
    TorqueBetween,
)
from supple.quantities import JointMotionSensor, PositionSensor, Quantity
from supple.stepping import StepProgram, Variable, step_program
from supple.stepping.parameters import Exported, MachineParameters
from supple.sweeps.body_numbers import number_of_run
from supple.terminal import print_rows, say, shown_step

Driven = Joint | ForceElement
"""A part of a machine whose law may be an input."""


def export_c(path: Path, folder: Path, options: ExportOptions) -> None:
    """Write the machine of a case, or of a result, at the start of its run, as a folder of C source.

    Raises
    ------
    CaseError           mistakes in the case file; an unknown input; a body that corrects itself
    ModelError          as for `step_program` and `write_machine`
    ResultFileError     a file that cannot be read or written
    """
    _export(path, folder, options, lambda step, title: write_machine(folder, step, title))
    say(f"written to {folder}: run make test there")


def export_fmu(path: Path, target: Path, options: ExportOptions) -> None:
    """Write the machine as an FMU.

    Raises ArgumentError for an unknown operating system, and as for `export_c`, `write_fmu`, `linear_form`.
    """
    fmi, platforms = options.fmi or 3, _platforms(options.platforms or ())
    if options.linear:
        _export_linear(path, target, options, fmi, platforms)
    else:
        _export(path, target, options, partial(write_fmu, target, fmi=fmi, platforms=platforms))
    say(f"written to {target}, FMI {fmi}")


@contextmanager
def _opened(path: Path, target: Path, options: ExportOptions) -> Iterator[tuple[Case, System, Notify]]:
    """Case, machine and the display of the current step; CaseError if the target is an input of the case."""
    with shown_step("reading") as notify:
        case, system = _machine(path, options, notify)
        check_not_an_input(case, [target])
        yield case, system, notify


def _export(
    path: Path, target: Path, options: ExportOptions, write: Callable[[StepProgram, str], object]
) -> None:
    with _opened(path, target, options) as (case, system, notify):
        notify("tracing the equations")
        step = _step(case, system, options.inputs or ())
        notify("writing")
        write(step, case.title or path.stem)
    rows = {
        "coordinates": f"{step.march.n_velocities} velocities, {step.n_equations} equations of joints",
        "step": f"{step.size:g}",
        "parameters": _listed(step.parameters),
        "inputs": _listed(step.inputs.variables, "none (time only)"),
        "outputs": _listed(step.outputs.variables),
    }
    _report("Machine", rows, step.outputs.left_out)


def _export_linear(
    path: Path, target: Path, options: ExportOptions, fmi: int, platforms: tuple[Platform, ...]
) -> None:
    with _opened(path, target, options) as (case, system, notify):
        if case.tables.parameter:
            raise CaseError(
                f"{case.path}: the matrices of a linear machine have no parameters; remove [[parameter]], or "
                "export one machine for each value"
            )
        notify("linearising")
        chosen, units = chosen_inputs(case, system, options.inputs or ())
        sensors = machine_outputs(case, system)
        form = linear_form(system, case.run, sensors, chosen, input_units=units, units=case.units)
        notify("writing")
        write_linear_fmu(target, form, case.title or path.stem, fmi=fmi, platforms=platforms)
    rows = {
        "states": str(len(form.state)),
        "inputs": _listed(form.inputs),
        "outputs": _listed(form.outputs),
        "relative deviation of the first accelerations from the nonlinear ones": f"{form.deviation:.2g}",
    }
    _report("Linear machine", rows, form.left_out)


def _listed(variables: Sequence[Variable], none: str = "none") -> str:
    return ", ".join(variable.name for variable in variables) or none


def _report(title: str, rows: Mapping[str, str], left_out: Sequence[str]) -> None:
    print_rows(title, rows.items())
    if left_out:
        say(f"left out, because only results contain them: {', '.join(left_out)}")


def _platforms(names: Sequence[str]) -> tuple[Platform, ...]:
    for name in names:
        if name not in PLATFORMS:
            raise ArgumentError(
                f"there is no platform '{name}'{did_you_mean(name, PLATFORMS)}; there are: "
                f"{', '.join(PLATFORMS)}"
            )
    return tuple(each for name in dict.fromkeys(names) for each in PLATFORMS[name])


def _machine(path: Path, options: ExportOptions, notify: Notify) -> tuple[Case, System]:
    if path.suffix.lower() != ".toml":
        found = result_machine(path, options.case, notify)
        return found.case, starting_system(found.case, found.system, allow_code=options.allow_code)
    case = read_case(path, notify)
    if case.starts:
        raise CaseError(
            f"{path}: body '{next(iter(case.starts))}' is reduced to an accuracy during its run: run "
            "the case, and export its result (.h5)"
        )
    return case, starting_system(case, allow_code=options.allow_code)


def chosen_inputs(
    case: Case, system: System, names: Sequence[str]
) -> tuple[dict[str, Driven], dict[str, str]]:
    """The elements whose laws are inputs, and the units of the inputs, by name."""
    known = _elements(case, system)
    for name in names:
        if name not in known:
            raise CaseError(
                f"{case.path} has no joint, spring or element '{name}'{did_you_mean(name, known)}"
            )
    chosen = {name: known[name] for name in names}
    return chosen, {name: _unit(case, element) for name, element in chosen.items()}


def _step(case: Case, system: System, inputs: Sequence[str]) -> StepProgram:
    chosen, units = chosen_inputs(case, system, inputs)
    return step_program(
        system,
        case.run,
        machine_outputs(case, system),
        chosen,
        input_units=units,
        units=case.units,
        parameters=_parameters(case, system, inputs),
    )


def _parameters(case: Case, system: System, inputs: Sequence[str]) -> MachineParameters | None:
    """The parameters of the case, with a function that builds the machine for given values; or None."""
    given = case.tables.parameter
    if not given:
        return None
    if case.tables.control is not None:
        raise CaseError(
            f"{case.path}: a machine with controllers cannot have parameters; remove control or [[parameter]]"
        )
    family = case_family(case.path)
    places, variables = [], []
    for table in given:
        place, value = number_of_run(case.path, table.path, family.raw)
        places.append(place)
        variables.append(Variable(table.name, table.unit, table.path, value))
    made = {each.body.name: each.body for each in system.bodies if each.body.kind != "rigid"}

    def machine(values: np.ndarray) -> Exported:
        varied = family.variant(dict(zip(places, map(float, values), strict=True)), case, made)
        own = starting_system(varied)
        known = _elements(varied, own)
        return own, machine_outputs(varied, own), {name: known[name] for name in inputs}

    return MachineParameters(tuple(variables), machine)


def _elements(case: Case, system: System) -> dict[str, Driven]:
    """Joints, and springs and elements that have a name."""
    return {joint.name: joint for joint in system.joints} | case.named_elements(system)


def _unit(case: Case, element: Driven) -> str:
    units = case.units
    match element:
        case PrescribedRotation() | AngleServo():
            return "rad"
        case PrescribedTranslation() | SlideServo():
            return units.length
        case TorqueBetween() | RevoluteFriction():
            return units.moment
        case ForceBetween() | PrismaticFriction():
            return units.force
    return ""


def machine_outputs(case: Case, system: System) -> list[Quantity]:
    """Sensors and tracked places of the case, and motions of joints about or along their axes.

    Only revolute, prismatic and cylindrical joints have such motions. A joint whose motion a sensor of the
    case measures gets no further output.
    """
    sensors = list(case.sensors)
    tracked = [PositionSensor(name, place) for name, place in case.track.items()]
    joints = [
        JointMotionSensor(joint.name, joint.name)
        for joint in system.joints
        if type(joint) in (Revolute, Prismatic, Cylindrical)
    ]
    taken = {sensor.name for sensor in sensors}
    seen = {sensor.joint for sensor in sensors if isinstance(sensor, JointMotionSensor)}
    sensors += [each for each in tracked if each.name not in taken]
    return [*sensors, *(each for each in joints if each.name not in taken and each.joint not in seen)]

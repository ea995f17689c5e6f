"""The XML files of an FMU: the description of its variables, and the build description."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from supple.export.linear.linear_form import LinearForm
from supple.stepping import StepProgram
from supple.stepping.variables import Variable

IDENTIFIER = "machine"
"""Model identifier: the file name of the binaries."""


@dataclass(frozen=True)
class FmuInterface:
    """Variables and run times of a machine, for the importer of an FMU.

    fixed_parameters : indices of the parameters that can be set before the start only
    time, size, duration : start time, time step and duration of the run of the case
    has_contacts : whether there are stops or contacts, which cause events
    """

    inputs: tuple[Variable, ...]
    outputs: tuple[Variable, ...]
    time: float
    size: float
    duration: float
    parameters: tuple[Variable, ...] = ()
    fixed_parameters: frozenset[int] = frozenset()
    has_contacts: bool = False

    @classmethod
    def of_steps(cls, step: StepProgram) -> FmuInterface:
        """The interface of a nonlinear machine, which is integrated in time steps."""
        return cls(
            step.inputs.variables,
            step.outputs.variables,
            float(step.start.state.time),
            step.size,
            step.duration,
            step.parameters,
            step.fixed_parameters,
            bool(len(step.start.touching)),
        )

    @classmethod
    def of_linear(cls, form: LinearForm) -> FmuInterface:
        """The interface of a linear machine."""
        return cls(form.inputs, form.outputs, form.time, form.size, form.duration)


def _written(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _root(fmi: str, title: str, **token: str) -> Element:
    own = {"fmiVersion": fmi, "modelName": title} | token
    by = {"generationTool": f"supple {version('supple')}", "variableNamingConvention": "flat"}
    return Element("fmiModelDescription", own | by)


def _units(root: Element, machine: FmuInterface) -> None:
    names = sorted({each.variable.unit for each in _referenced(machine)} - {""})
    if names:
        units = SubElement(root, "UnitDefinitions")
        for name in names:
            SubElement(units, "Unit", name=name)


def _co_simulation(root: Element, machine: FmuInterface, state: str, derivatives: str) -> Element:
    """The abilities of the machine; state, derivatives : their words in a version of FMI."""
    able = ["canHandleVariableCommunicationStepSize", f"canGetAndSet{state}", f"canSerialize{state}"]
    able += [derivatives] if machine.inputs else []
    return SubElement(root, "CoSimulation", {"modelIdentifier": IDENTIFIER} | dict.fromkeys(able, "true"))


def _experiment(root: Element, machine: FmuInterface) -> None:
    SubElement(
        root,
        "DefaultExperiment",
        startTime=repr(machine.time),
        stopTime=repr(machine.time + machine.duration),
        stepSize=repr(machine.size),
    )


class _Referenced(NamedTuple):
    """A variable with its value reference."""

    reference: int
    variable: Variable
    causality: str
    variability: str

    @property
    def named(self) -> dict[str, str]:
        """XML attributes of the variable."""
        return {
            "name": self.variable.name,
            "valueReference": str(self.reference),
            "description": self.variable.description,
            "causality": self.causality,
            "variability": self.variability,
        }

    @property
    def value(self) -> dict[str, str]:
        """XML attributes of its value: unit and start."""
        unit = {"unit": self.variable.unit} if self.variable.unit else {}
        start = {} if self.causality == "output" else {"start": repr(self.variable.start)}
        return unit | start


def _referenced(machine: FmuInterface) -> list[_Referenced]:
    """Parameters, inputs and outputs, with value references from 1; 0 is the time."""
    fixed = machine.fixed_parameters
    kinds = [
        *(
            (each, "parameter", "fixed" if k in fixed else "tunable")
            for k, each in enumerate(machine.parameters)
        ),
        *((each, "input", "continuous") for each in machine.inputs),
        *((each, "output", "continuous") for each in machine.outputs),
    ]
    return [_Referenced(place + 1, *each) for place, each in enumerate(kinds)]


def model_description_3(machine: FmuInterface, title: str, token: str) -> str:
    """The text of `modelDescription.xml` of FMI 3.0."""
    root = _root("3.0", title, instantiationToken=token)
    simulation = _co_simulation(root, machine, "FMUState", "providesDirectionalDerivatives")
    if machine.has_contacts:
        simulation.attrib |= {"hasEventMode": "true", "mightReturnEarlyFromDoStep": "true"}
    _units(root, machine)
    _experiment(root, machine)
    variables = SubElement(root, "ModelVariables")
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference="0",
        causality="independent",
        variability="continuous",
    )
    for each in _referenced(machine):
        SubElement(variables, "Float64", each.named | each.value)
    structure = SubElement(root, "ModelStructure")
    for kind in ("Output", "InitialUnknown"):
        for reference in _output_references(machine):
            SubElement(structure, kind, valueReference=str(reference))
    return _written(root)


def _output_references(machine: FmuInterface) -> list[int]:
    return [each.reference for each in _referenced(machine) if each.causality == "output"]


def model_description_2(machine: FmuInterface, title: str, token: str, sources: Sequence[str]) -> str:
    """The text of `modelDescription.xml` of FMI 2.0."""
    root = _root("2.0", title, guid=token)
    simulation = _co_simulation(root, machine, "FMUstate", "providesDirectionalDerivative")
    files = SubElement(simulation, "SourceFiles")
    for name in sources:
        SubElement(files, "File", name=name)
    _units(root, machine)
    _experiment(root, machine)
    variables = SubElement(root, "ModelVariables")
    for each in _referenced(machine):
        own = SubElement(variables, "ScalarVariable", each.named)
        SubElement(own, "Real", each.value)
    structure = SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        if machine.outputs:
            unknowns = SubElement(structure, kind)
            for reference in _output_references(
                machine
            ):  # indices count from 1, as the value references do here
                SubElement(unknowns, "Unknown", index=str(reference))
    return _written(root)


def build_description(sources: Sequence[str]) -> str:
    """The text of `sources/buildDescription.xml` of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=IDENTIFIER)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return _written(root)

"""The XML files of an FMU: its variables, and how it is built from its sources."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from supple.stepping import StepProgram
from supple.stepping.variables import Variable

__all__ = ["IDENTIFIER", "build_description", "model_description_2", "model_description_3"]

IDENTIFIER = "machine"
"""Of the binaries."""


def _written(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _root(fmi: str, title: str, **token: str) -> Element:
    own = {"fmiVersion": fmi, "modelName": title} | token
    by = {"generationTool": f"supple {version('supple')}", "variableNamingConvention": "flat"}
    return Element("fmiModelDescription", own | by)


def _units(root: Element, step: StepProgram) -> None:
    names = sorted({each.variable.unit for each in _referenced(step)} - {""})
    if names:
        units = SubElement(root, "UnitDefinitions")
        for name in names:
            SubElement(units, "Unit", name=name)


def _experiment(root: Element, step: StepProgram) -> None:
    start = float(step.start.state.time)
    SubElement(
        root,
        "DefaultExperiment",
        startTime=repr(start),
        stopTime=repr(start + step.duration),
        stepSize=repr(step.size),
    )


class _Referenced(NamedTuple):
    """A variable under its value reference."""

    reference: int
    variable: Variable
    causality: str
    variability: str

    @property
    def named(self) -> dict[str, str]:
        """Attributes of the variable."""
        return {
            "name": self.variable.name,
            "valueReference": str(self.reference),
            "description": self.variable.description,
            "causality": self.causality,
            "variability": self.variability,
        }

    @property
    def value(self) -> dict[str, str]:
        """Attributes of its value: unit and start."""
        unit = {"unit": self.variable.unit} if self.variable.unit else {}
        start = {} if self.causality == "output" else {"start": repr(self.variable.start)}
        return unit | start


def _referenced(step: StepProgram) -> list[_Referenced]:
    """Parameters, inputs and outputs; 0 is the time."""
    fixed = step.fixed_parameters
    kinds = [
        *(
            (each, "parameter", "fixed" if k in fixed else "tunable")
            for k, each in enumerate(step.parameters)
        ),
        *((each, "input", "continuous") for each in step.inputs.variables),
        *((each, "output", "continuous") for each in step.outputs.variables),
    ]
    return [_Referenced(place + 1, *each) for place, each in enumerate(kinds)]


def model_description_3(step: StepProgram, title: str, token: str) -> str:
    """`modelDescription.xml` of FMI 3.0."""
    root = _root("3.0", title, instantiationToken=token)
    simulation = {
        "modelIdentifier": IDENTIFIER,
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    if step.inputs.variables:
        simulation["providesDirectionalDerivatives"] = "true"
    if len(step.start.touching):
        simulation |= {"hasEventMode": "true", "mightReturnEarlyFromDoStep": "true"}
    SubElement(root, "CoSimulation", simulation)
    _units(root, step)
    _experiment(root, step)
    variables = SubElement(root, "ModelVariables")
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference="0",
        causality="independent",
        variability="continuous",
    )
    for each in _referenced(step):
        SubElement(variables, "Float64", each.named | each.value)
    structure = SubElement(root, "ModelStructure")
    for kind in ("Output", "InitialUnknown"):
        for reference in _output_references(step):
            SubElement(structure, kind, valueReference=str(reference))
    return _written(root)


def _output_references(step: StepProgram) -> list[int]:
    return [each.reference for each in _referenced(step) if each.causality == "output"]


def model_description_2(step: StepProgram, title: str, token: str, sources: Sequence[str]) -> str:
    """`modelDescription.xml` of FMI 2.0."""
    root = _root("2.0", title, guid=token)
    attributes = {
        "modelIdentifier": IDENTIFIER,
        "canHandleVariableCommunicationStepSize": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    if step.inputs.variables:
        attributes["providesDirectionalDerivative"] = "true"
    simulation = SubElement(root, "CoSimulation", attributes)
    files = SubElement(simulation, "SourceFiles")
    for name in sources:
        SubElement(files, "File", name=name)
    _units(root, step)
    _experiment(root, step)
    variables = SubElement(root, "ModelVariables")
    for each in _referenced(step):
        own = SubElement(variables, "ScalarVariable", each.named)
        SubElement(own, "Real", each.value)
    structure = SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        if step.outputs.variables:
            unknowns = SubElement(structure, kind)
            for reference in _output_references(step):  # places count from 1, as references do here
                SubElement(unknowns, "Unknown", index=str(reference))
    return _written(root)


def build_description(sources: Sequence[str]) -> str:
    """`sources/buildDescription.xml` of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=IDENTIFIER)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    return _written(root)

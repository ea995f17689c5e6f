"""The XML files of an FMU: its variables, and how it is built from its sources."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from supple.export.c.machine_step import MachineStep
from supple.export.c.variables import Variable

__all__ = ["IDENTIFIER", "build_description", "model_description_2", "model_description_3"]

IDENTIFIER = "machine"
"""Of the binaries."""


def _written(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _units(root: Element, step: MachineStep) -> None:
    every = (*step.inputs.variables, *step.outputs.variables)
    names = sorted({variable.unit for variable in every} - {""})
    if names:
        units = SubElement(root, "UnitDefinitions")
        for name in names:
            SubElement(units, "Unit", name=name)


def _experiment(root: Element, step: MachineStep) -> None:
    start = float(step.start.state.time)
    SubElement(
        root,
        "DefaultExperiment",
        startTime=repr(start),
        stopTime=repr(start + step.duration),
        stepSize=repr(step.size),
    )


def _referenced(step: MachineStep) -> list[tuple[int, Variable, str]]:
    """Value references, variables and what they are; 0 is the time."""
    inputs = [(variable, "input") for variable in step.inputs.variables]
    outputs = [(variable, "output") for variable in step.outputs.variables]
    return [(place + 1, *each) for place, each in enumerate([*inputs, *outputs])]


def _attributes(variable: Variable) -> dict[str, str]:
    return {"unit": variable.unit} if variable.unit else {}


def model_description_3(step: MachineStep, title: str, token: str) -> str:
    """`modelDescription.xml` of FMI 3.0."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=title,
        instantiationToken=token,
        generationTool=f"supple {version('supple')}",
        variableNamingConvention="flat",
    )
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
    )
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
    for reference, variable, causality in _referenced(step):
        own = _attributes(variable) | ({"start": repr(variable.start)} if causality == "input" else {})
        SubElement(
            variables,
            "Float64",
            {"name": variable.name, "valueReference": str(reference), "description": variable.description},
            causality=causality,
            variability="continuous",
            **own,
        )
    structure = SubElement(root, "ModelStructure")
    for kind in ("Output", "InitialUnknown"):
        for reference in _output_references(step):
            SubElement(structure, kind, valueReference=str(reference))
    return _written(root)


def _output_references(step: MachineStep) -> list[int]:
    return [reference for reference, _, causality in _referenced(step) if causality == "output"]


def model_description_2(step: MachineStep, title: str, token: str, sources: Sequence[str]) -> str:
    """`modelDescription.xml` of FMI 2.0."""
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=title,
        guid=token,
        generationTool=f"supple {version('supple')}",
        variableNamingConvention="flat",
    )
    simulation = SubElement(
        root,
        "CoSimulation",
        modelIdentifier=IDENTIFIER,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    files = SubElement(simulation, "SourceFiles")
    for name in sources:
        SubElement(files, "File", name=name)
    _units(root, step)
    _experiment(root, step)
    variables = SubElement(root, "ModelVariables")
    for reference, variable, causality in _referenced(step):
        own = SubElement(
            variables,
            "ScalarVariable",
            {"name": variable.name, "valueReference": str(reference), "description": variable.description},
            causality=causality,
            variability="continuous",
        )
        start = {"start": repr(variable.start)} if causality == "input" else {}
        SubElement(own, "Real", _attributes(variable) | start)
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

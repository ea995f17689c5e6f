"""The part of `against_kratos.py` that runs in Kratos' interpreter, without supple.

    python kratos_run.py FOLDER

FOLDER holds case.npz (points, cells, velocities) and case.json. The script writes a line with the versions.
For every line read from standard input it repeats the march, writes a line with the time, and stores the
final positions in places.npy. Kratos Multiphysics (BSD licence) must be installed; no code of it is contained
here.
"""

from __future__ import annotations

import json
import os
import sys
from importlib.metadata import version
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np


def main(folder: Path) -> None:
    output = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # Kratos prints on the way, from C++ too
    import KratosMultiphysics as Kratos

    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    arrays = dict(np.load(folder / "case.npz"))
    packages = ("KratosMultiphysics", "KratosStructuralMechanicsApplication")
    write_line(output, {name: version(name) for name in packages} | {"python": sys.version.split()[0]})
    for _ in sys.stdin:
        part = model_part(Kratos.Model(), case, arrays)
        march = strategy(part)
        began, began_wall = process_time(), perf_counter()
        for number in range(1, case["steps"] + 1):
            part.CloneTimeStep(number * case["step"])
            part.ProcessInfo[Kratos.STEP] = number
            march.Solve()
        spent = {"processor": process_time() - began, "wall": perf_counter() - began_wall}
        np.save(folder / "places.npy", [[node.X, node.Y, node.Z] for node in part.Nodes])
        write_line(output, spent)


def model_part(model: Any, case: dict[str, Any], arrays: dict[str, np.ndarray]) -> Any:
    """The nodes, elements and initial velocities of the case."""
    import KratosMultiphysics as Kratos
    import KratosMultiphysics.StructuralMechanicsApplication as Structures

    part = model.CreateModelPart("block")
    part.SetBufferSize(2)
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
    for variable in (
        Kratos.DISPLACEMENT,
        Kratos.VELOCITY,
        Kratos.ACCELERATION,
        Kratos.REACTION,
        Kratos.VOLUME_ACCELERATION,
        Kratos.NODAL_MASS,
        Kratos.FORCE_RESIDUAL,
        Kratos.RESIDUAL_VECTOR,
        Structures.MIDDLE_VELOCITY,
    ):
        part.AddNodalSolutionStepVariable(variable)
    for number, (point, velocity) in enumerate(zip(arrays["points"], arrays["velocities"], strict=True), 1):
        node = part.CreateNewNode(number, *point.tolist())
        node.SetSolutionStepValue(Kratos.VELOCITY, velocity.tolist())
    properties = part.CreateNewProperties(1)
    properties[Kratos.YOUNG_MODULUS], properties[Kratos.POISSON_RATIO] = case["young"], case["poisson"]
    properties[Kratos.DENSITY] = case["density"]
    properties[Kratos.CONSTITUTIVE_LAW] = Structures.LinearElastic3DLaw()
    properties[Structures.INTEGRATION_ORDER] = case["order"]
    for number, cell in enumerate(arrays["cells"] + 1, 1):
        part.CreateNewElement(case["element"], number, cell.tolist(), properties)
    for axis in "XYZ":
        moved, held = (getattr(Kratos, f"{name}_{axis}") for name in ("DISPLACEMENT", "REACTION"))
        Kratos.VariableUtils().AddDof(moved, held, part)
    part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = True
    part.ProcessInfo[Kratos.TIME], part.ProcessInfo[Kratos.DELTA_TIME] = 0.0, case["step"]
    return part


def strategy(part: Any) -> Any:
    """Central differences with the given step, without reactions, initialised."""
    import KratosMultiphysics.StructuralMechanicsApplication as Structures

    scheme = Structures.ExplicitCentralDifferencesScheme(1.0, 1.0, 0.0)  # the last: no step of its own
    march = Structures.MechanicalExplicitStrategy(part, scheme, False, False, True)  # the mesh has to move
    march.Initialize()
    return march


def write_line(output: Any, what: dict[str, Any]) -> None:
    print(json.dumps(what), file=output, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Export of a machine as an FMU: description, sources, and libraries for some platforms."""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from supple.errors import ModelError
from supple.export.c.machine_source import derivative_source, machine_sources
from supple.export.fmu.model_description import (
    IDENTIFIER,
    FmuInterface,
    build_description,
    model_description_2,
    model_description_3,
)
from supple.export.fmu.platforms import Compiler, Platform, compilers_of
from supple.export.fmu.prebuilt import prebuilt_libraries
from supple.export.linear.linear_form import LinearForm
from supple.stepping import StepProgram
from supple.storage.atomic_write import replacing

_WRAPPERS = {2: "fmi2.c", 3: "fmi3.c"}


def write_fmu(
    path: Path, step: StepProgram, title: str, *, fmi: int = 3, platforms: tuple[Platform, ...] = ()
) -> Path:
    """Write a machine as an FMU for co-simulation; returns the path.

    fmi : version of the interface, 3 or 2
    platforms : platforms of the libraries (`PLATFORMS`); by default that of this computer

    Raises
    ------
    ModelError          `fmi` is not 3 or 2; there is no compiler, or it fails; an operation of the equations
                        cannot be translated to C
    ResultFileError     the file cannot be written
    """
    _check_version(fmi)
    compilers = compilers_of(platforms, fmi)  # first, because generating the sources takes longer
    made = machine_sources(step, title)
    # Equal machines have equal tokens, because importers may cache data by token.
    token = _token((made["machine.c"] + made["machine.h"]).encode())
    simulation = Template(_asset("printed_simulation.h")).substitute(token=token, **_of_simulation(step))
    sources = {
        "machine.c": made["machine.c"],
        "machine.h": made["machine.h"],
        "simulation.h": simulation,
    }
    if step.inputs.variables:
        sources["derivative.c"] = derivative_source(step)
    sources |= _wrapper(fmi)
    libraries = _compiled(sources, compilers)
    return _write(path, FmuInterface.of_steps(step), title, token, sources, {}, fmi, libraries)


def write_linear_fmu(
    path: Path, form: LinearForm, title: str, *, fmi: int = 3, platforms: tuple[Platform, ...] = ()
) -> Path:
    """Write a linear machine as an FMU for co-simulation; returns the path.

    Arguments and errors as for `write_fmu`, except that `platforms` are by default all those for which the
    package contains a prebuilt library. If it contains none, or none for one of the given platforms, all
    libraries are compiled as in `write_fmu`.

    The libraries read the matrices from `resources/linear.bin`. This file has the token and little-endian
    doubles: the number 1 (version of this format); the numbers of states, inputs and outputs; start time and
    time step of the run; inputs at rest; outputs at rest; states at the start; A, B, C, D by rows.
    """
    _check_version(fmi)
    head = [1, len(form.state), len(form.inputs), len(form.outputs), form.time, form.size]
    given = [each.start for each in form.inputs]
    arrays = (head, given, form.rest, form.state, form.a, form.b, form.c, form.d)
    numbers = np.concatenate([np.ravel(np.asarray(each, dtype="<f8")) for each in arrays]).tobytes()
    token = _token(numbers)
    sources = linear_sources(fmi)
    libraries = prebuilt_libraries(sources, fmi, platforms) or _compiled(
        sources, compilers_of(platforms, fmi)
    )
    resources = {"linear.bin": token.encode() + numbers}
    return _write(path, FmuInterface.of_linear(form), title, token, sources, resources, fmi, libraries)


def linear_sources(fmi: int) -> dict[str, str]:
    """Sources of the library that all linear machines share, by file name."""
    return {"simulation.h": _asset("linear_simulation.h")} | _wrapper(fmi)


def _check_version(fmi: int) -> None:
    if fmi not in _WRAPPERS:
        raise ModelError(f"no FMU of FMI {fmi} can be written: choose 3 or 2")


def _wrapper(fmi: int) -> dict[str, str]:
    return {name: _asset(name) for name in ("instance.h", _WRAPPERS[fmi])}


def _token(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:32]


def _write(
    path: Path,
    machine: FmuInterface,
    title: str,
    token: str,
    sources: Mapping[str, str],
    resources: Mapping[str, bytes],
    fmi: int,
    libraries: Sequence[tuple[Platform, bytes]],
) -> Path:
    """Write the archive: description, sources, libraries by platform, and resources."""
    compiled = [name for name in sources if name.endswith(".c")]
    parts: dict[str, str | bytes] = {f"sources/{name}": own for name, own in sources.items()}
    parts |= {f"resources/{name}": own for name, own in resources.items()}
    if fmi == 3:
        parts["modelDescription.xml"] = model_description_3(machine, title, token)
        parts["sources/buildDescription.xml"] = build_description(compiled)
    else:
        parts["modelDescription.xml"] = model_description_2(machine, title, token, compiled)
    for platform, library in libraries:
        parts[f"binaries/{platform.folders[fmi]}/{IDENTIFIER}{platform.suffix}"] = library
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(parts):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, parts[name], zipfile.ZIP_DEFLATED)
    return path


def _of_simulation(step: StepProgram) -> dict[str, str]:
    """Values of the placeholders of `simulation.h`."""
    first = "parameter" if step.parameters else "input" if step.inputs.variables else None
    numbers = range(len(step.parameters))
    return {
        "given_at": "0" if first is None else f"offsetof(machine, {first})",
        "tunable": ", ".join("false" if k in step.fixed_parameters else "true" for k in numbers) or "false",
    }


def _asset(name: str) -> str:
    return files("supple.export.fmu").joinpath("assets", name).read_text("utf-8")


def _compiled(sources: Mapping[str, str], compilers: tuple[Compiler, ...]) -> list[tuple[Platform, bytes]]:
    return [(each.platform, compile_library(each, sources)) for each in compilers]


def compile_library(compiler: Compiler, sources: Mapping[str, str]) -> bytes:
    """The shared library of an FMU for one platform; ModelError where the compiler fails."""
    compiled = [name for name in sources if name.endswith(".c")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, "utf-8")
        own = os.environ.get("CFLAGS", "-O2 -ffp-contract=off").split()
        options = ["-std=c99", *own, "-fPIC", "-shared", "-fvisibility=hidden"]
        target = f"{IDENTIFIER}{compiler.platform.suffix}"
        command = " ".join(compiler.command)
        try:
            done = subprocess.run(
                [*compiler.command, *options, "-o", target, *compiled, "-lm"],
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
            )
        except OSError as error:
            raise ModelError(
                f"the compiler {command} does not start ({error}): check the variable CC"
            ) from error
        if done.returncode:
            raise ModelError(
                f"{command} could not build the FMU: {done.stderr.strip()[-400:]}; check the variables CC "
                "and CFLAGS, or export the machine as C and build it there"
            )
        return (folder / target).read_bytes()

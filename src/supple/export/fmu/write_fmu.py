"""Write a machine as an FMU: a description, its sources, and libraries for kinds of computers."""

from __future__ import annotations

import hashlib
import os
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from string import Template

from supple.errors import ModelError
from supple.export.c.machine_source import machine_sources
from supple.export.fmu.derivative_source import derivative_source
from supple.export.fmu.model_description import (
    IDENTIFIER,
    build_description,
    model_description_2,
    model_description_3,
)
from supple.export.fmu.platforms import Compiler, Platform, compilers_of
from supple.stepping import StepProgram
from supple.storage.atomic_write import replacing

__all__ = ["write_fmu"]

_WRAPPERS = {2: "fmi2.c", 3: "fmi3.c"}


def write_fmu(
    path: Path, step: StepProgram, title: str, *, fmi: int = 3, platforms: tuple[Platform, ...] = ()
) -> Path:
    """Write an FMU for co-simulation.

    fmi : version of the interface, 3 or 2
    platforms : kinds of computers that it has libraries for (`PLATFORMS`); this one where none is given

    Raises
    ------
    ModelError          another version; no compiler, or one that fails; an operation of the equations that
                        has no form in C
    ResultFileError     a file that cannot be written
    """
    if fmi not in _WRAPPERS:
        raise ModelError(f"FMUs of FMI 3 and 2 are written, not of {fmi}: give one of these")
    compilers = compilers_of(platforms, fmi)
    made = machine_sources(step, title)
    # One and the same machine has one token: an importer may cache what it knows of it.
    token = hashlib.sha256((made["machine.c"] + made["machine.h"]).encode()).hexdigest()[:32]
    wrapper = _WRAPPERS[fmi]
    instance = Template(_asset("instance.h")).substitute(token=token, **_of_instance(step))
    sources = {
        "machine.c": made["machine.c"],
        "machine.h": made["machine.h"],
        "instance.h": instance,
        wrapper: _asset(wrapper),
    }
    if step.inputs.variables:
        sources["derivative.c"] = derivative_source(step)
    compiled = [name for name in sources if name.endswith(".c")]
    parts: dict[str, str | bytes] = {f"sources/{name}": own for name, own in sources.items()}
    if fmi == 3:
        parts["modelDescription.xml"] = model_description_3(step, title, token)
        parts["sources/buildDescription.xml"] = build_description(compiled)
    else:
        parts["modelDescription.xml"] = model_description_2(step, title, token, compiled)
    for each in compilers:
        name = f"binaries/{each.platform.folders[fmi]}/{IDENTIFIER}{each.platform.suffix}"
        parts[name] = _library(each, sources, compiled)
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(parts):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, parts[name], zipfile.ZIP_DEFLATED)
    return path


def _of_instance(step: StepProgram) -> dict[str, str]:
    """Parts of `instance.h`."""
    first = "parameter" if step.parameters else "input" if step.inputs.variables else None
    numbers = range(len(step.parameters))
    return {
        "given_at": "0" if first is None else f"offsetof(machine, {first})",
        "tunable": ", ".join("false" if k in step.fixed_parameters else "true" for k in numbers) or "false",
    }


def _asset(name: str) -> str:
    return files("supple.export.fmu").joinpath("assets", name).read_text("utf-8")


def _library(compiler: Compiler, sources: Mapping[str, str], compiled: list[str]) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, "utf-8")
        own = os.environ.get("CFLAGS", "-O2 -ffp-contract=off").split()
        options = ["-std=c99", *own, "-fPIC", "-shared", "-fvisibility=hidden"]
        target = f"{IDENTIFIER}{compiler.platform.suffix}"
        done = subprocess.run(
            [*compiler.command, *options, "-o", target, *compiled, "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            command = " ".join(compiler.command)
            raise ModelError(f"{command} could not build the FMU: {done.stderr.strip()[-400:]}")
        return (folder / target).read_bytes()

"""Export of a machine as a folder of C files."""

from __future__ import annotations

from pathlib import Path

from supple.export.ascii_file import check_not_foreign
from supple.export.c.machine_source import machine_files
from supple.stepping import StepProgram
from supple.storage.atomic_write import replacing

__all__ = ["write_machine"]


def write_machine(folder: Path, step: StepProgram, title: str) -> tuple[Path, ...]:
    """Write `machine.c`, `machine.h`, `test.c` and `Makefile`, in place of old files; returns their paths.

    Raises
    ------
    ModelError          an operation of the equations without a translation to C
    ResultFileError     the folder cannot be written, or has another file of one of these names
    """
    for name in ("machine.c", "machine.h", "test.c", "Makefile"):
        check_not_foreign(folder / name, "machine")
    files = machine_files(step, title)
    for name, text in files.items():
        with replacing(folder / name) as temporary:
            temporary.write_text(text, "utf-8")
    return tuple(folder / name for name in files)

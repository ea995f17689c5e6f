"""Write a mode of a case's machine for ParaView."""

from __future__ import annotations

from pathlib import Path

from supple.cases import read_case
from supple.cases.modes_case import mode_case
from supple.cases.run_files import check_not_an_input
from supple.cli.export import ExportOptions
from supple.errors import ArgumentError
from supple.export import write_vtkhdf, write_vtu
from supple.terminal import say, shown_step


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
    if path.suffix.lower() != ".toml" or suffix not in (".vtkhdf", ".vtu"):
        raise ArgumentError("--mode needs a case (.toml) and a file .vtkhdf or .vtu")
    with shown_step("reading") as notify:
        case = read_case(path, notify)
        check_not_an_input(case, [target])
        system, motion = mode_case(case, options.mode, time=options.time or 0.0)
        write, shown = (write_vtu, motion.at(slice(1))) if suffix == ".vtu" else (write_vtkhdf, motion)
        bodies = case.names_in_machine(options.body or ()) or None
        write(target, system, shown, case.meshes, bodies=bodies, bases=case.bases, units=case.units)
    say(f"mode {options.mode} written to {target}")

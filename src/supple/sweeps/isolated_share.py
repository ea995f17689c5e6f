"""Search for cases that kill their process: cases run in isolated processes, and the cause is recorded."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from supple.errors import ResultFileError
from supple.other_processes import python_command, python_environment
from supple.sweeps.fatigue_loads import summed_spectra
from supple.sweeps.part_file import CaseRecord, CaseStatus, Part, read_part
from supple.sweeps.plan import read_plan

TRIES = 2
"""Number of processes that a single case may kill before it is recorded."""
_REFUSED = 3
"""Exit code of a process that ends with an error other than that of a case."""


def isolated_share(folder: Path, cases: Sequence[int], level: int, *, allow_code: bool = False) -> Part:
    """The results of some cases, run in a separate process.

    If the process is killed, each half of the cases runs in a process of its own, and so on.

    level, allow_code : as in `run_cases`
    Raises ResultFileError for errors of the computer or the disk.
    """
    with tempfile.TemporaryDirectory(prefix="supple-sweep-") as place:
        part = _found(folder, cases, [str(level), str(int(allow_code))], Path(place))
    in_order = sorted(part.results, key=lambda each: each.case)
    names = read_plan(folder).output.statistics
    return Part(in_order, tuple(dict.fromkeys(part.warnings)), names, part.spectrum)


def _found(folder: Path, cases: Sequence[int], options: Sequence[str], place: Path) -> Part:
    target, code, words = place / f"{cases[0]}-{cases[-1]}.h5", 0, ""
    for _ in range(TRIES if len(cases) == 1 else 1):
        code, words = _process(folder, cases, options, target)
        if code == 0:
            return read_part(target)
        if code == _REFUSED:
            raise ResultFileError(words)
    if len(cases) == 1:
        return Part([CaseRecord(cases[0], CaseStatus.KILLED, _cause(code, words))])
    half = len(cases) // 2
    parts = [_found(folder, own, options, place) for own in (cases[:half], cases[half:])]
    return Part(
        [each for own in parts for each in own.results],
        [each for own in parts for each in own.warnings],
        spectrum=summed_spectra([own.spectrum for own in parts]),
    )


def _process(folder: Path, cases: Sequence[int], options: Sequence[str], target: Path) -> tuple[int, str]:
    """Run cases in a separate process, which writes a file; returns its exit code and last error line."""
    words = [str(folder), str(target), *options, *map(str, cases)]
    done = subprocess.run(
        python_command("-m", __name__, *words),
        env=python_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stderr.strip().splitlines()
    return done.returncode, lines[-1] if lines else ""


def _cause(code: int, words: str) -> str:
    """Why a process ended, as text."""
    if code >= 0:
        return f"its process ended with code {code}: {words}"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = "unknown"
    memory = ", usually because memory ran out" if name == "SIGKILL" else ""
    return f"its process was killed by signal {-code} ({name}){memory}"


def _main(folder: str, target: str, level: str, allow_code: str, *cases: str) -> None:
    from supple.errors import SuppleError
    from supple.sweeps.part_file import write_part
    from supple.sweeps.run_share import run_cases

    try:
        numbers, allowed = [int(case) for case in cases], bool(int(allow_code))
        part = run_cases(Path(folder), numbers, int(level), allow_code=allowed)
        write_part(Path(target), part)
    except SuppleError as error:
        sys.stderr.write(f"{error}\n")
        sys.exit(_REFUSED)


if __name__ == "__main__":
    _main(*sys.argv[1:])

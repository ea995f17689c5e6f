"""Another code in its own Python environment: a process that repeats a run on request."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

__all__ = ["PeerProcess"]


class PeerProcess:
    """A script run by another interpreter, and the (processor, wall) seconds of its runs.

    The argument of the script is a folder with the files of the case, including `case.json`. The script
    writes a line of JSON when it is ready, and a line `{"processor": s, "wall": s}` after each run; it starts
    a run for every line written to it.

    code : name of the code;   prepare : function that writes the further files of the folder
    """

    def __init__(
        self,
        code: str,
        interpreter: Path,
        script: str,
        case: dict[str, Any],
        prepare: Callable[[Path], None],
    ) -> None:
        self._code = code
        self._temporary = TemporaryDirectory()
        self.folder = Path(self._temporary.name)
        prepare(self.folder)
        (self.folder / "case.json").write_text(json.dumps(case), encoding="utf-8")
        with (self.folder / "log").open("w") as log:
            self._process = subprocess.Popen(
                [interpreter, Path(__file__).with_name(script).resolve(), self.folder],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                cwd=self.folder,
                # Flags for this environment's JAX: another version may not support them, and end.
                env={name: value for name, value in os.environ.items() if name != "XLA_FLAGS"},
            )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._requests, self._replies = self._process.stdin, self._process.stdout
        self.ready = self._reply()
        self.costs: list[tuple[float, float]] = []

    def turn(self) -> None:
        """Repeat the run from the start."""
        print(file=self._requests, flush=True)
        reply = self._reply()
        self.costs.append((reply["processor"], reply["wall"]))

    def close(self) -> None:
        """End the process."""
        self._requests.close()
        self._process.wait()
        self._temporary.cleanup()

    def _reply(self) -> dict[str, Any]:
        line = self._replies.readline()
        if not line:
            sys.exit(f"{self._code} stopped:\n" + (self.folder / "log").read_text()[-2000:])
        return json.loads(line)

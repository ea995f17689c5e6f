"""A code that stands in an environment of its own: a process that waits for its turns."""

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
    """A script that another interpreter runs, and the (processor, wall) seconds of its turns.

    The script is told a folder with the files of its case, `case.json` among them. It answers with a line of
    JSON when it is ready, and with another, `{"processor": s, "wall": s}`, whenever a line is written to it.

    code : its name;   filled : what else the folder is filled with, before the script starts
    """

    def __init__(
        self,
        code: str,
        interpreter: Path,
        script: str,
        case: dict[str, Any],
        filled: Callable[[Path], None],
    ) -> None:
        self._code = code
        self._kept = TemporaryDirectory()
        self.folder = Path(self._kept.name)
        filled(self.folder)
        (self.folder / "case.json").write_text(json.dumps(case), encoding="utf-8")
        with (self.folder / "log").open("w") as log:
            self._process = subprocess.Popen(
                [interpreter, Path(__file__).with_name(script).resolve(), self.folder],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                cwd=self.folder,
                # Of this environment's JAX: another version may not know them, and end.
                env={name: value for name, value in os.environ.items() if name != "XLA_FLAGS"},
            )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._asked, self._answers = self._process.stdin, self._process.stdout
        self.ready = self._told()
        self.costs: list[tuple[float, float]] = []

    def turn(self) -> None:
        """March once more, from the start."""
        print(file=self._asked, flush=True)
        told = self._told()
        self.costs.append((told["processor"], told["wall"]))

    def close(self) -> None:
        """Let it end."""
        self._asked.close()
        self._process.wait()
        self._kept.cleanup()

    def _told(self) -> dict[str, Any]:
        answer = self._answers.readline()
        if not answer:
            sys.exit(f"{self._code} stopped:\n" + (self.folder / "log").read_text()[-2000:])
        return json.loads(answer)

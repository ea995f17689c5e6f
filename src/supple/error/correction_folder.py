"""A self-correcting reduction on disk: the bases and the motion of every round, written as they are computed.

round-<k>.h5        the motion of run k, a result file (see `storage`)
round-<k>.stopped   the reason why run k ended before its last output time, if it did
round-<k>.npz       written before run k starts: the case and its inputs; per body its basis V, the report of
                    the reduction, and its error and indicator in run k - 1; the file ends in a checksum
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Self
from zipfile import BadZipFile

import numpy as np

from supple.body import FullBody
from supple.error.round_archive import MissedMotion, RoundBases
from supple.errors import ResultFileError
from supple.integrate import Progress, Run, Solution
from supple.machine import System
from supple.reduction import ReductionBasis, ReductionReport
from supple.simulation.recorded_run import check_recorded, simulate_recorded
from supple.storage.atomic_write import replacing
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import DAMAGE, file_errors
from supple.storage.file_seal import sealed, unsealed
from supple.storage.result_reader import read_header, read_solution
from supple.storage.run_inputs import Inputs, changes

__all__ = ["CorrectionFolder"]


class CorrectionFolder:
    """Stores the rounds of a self-correction in a folder (a `RoundArchive`), from which it can be resumed.

    Finished rounds are read from the folder. An interrupted run is continued with bit-identical results. The
    projections of the bodies on their bases and the distances between the runs are computed again.

        self_correct(..., archive=CorrectionFolder.create(folder, case=text))
    """

    def __init__(self, folder: Path | str, *, case: str, inputs: Inputs | None = None) -> None:
        self.folder = Path(folder)
        self._case = case
        self._inputs = inputs

    @classmethod
    def create(cls, folder: Path | str, *, case: str, inputs: Inputs | None = None) -> Self:
        """Start a new archive, and delete the rounds in the folder.

        inputs : data on which the rounds depend, stored in each result file; default: system, run and case

        Raises
        ------
        ResultFileError     the folder cannot be written, or another run is writing one of its rounds
        """
        archive = cls(folder, case=case, inputs=inputs)
        with file_errors("write", archive.folder):
            archive.folder.mkdir(parents=True, exist_ok=True)
            for pattern in ("round-*.h5", "round-*.npz", "round-*.stopped"):
                for path in archive.folder.glob(pattern):
                    with ExclusiveLock(path):
                        path.unlink()
        return archive

    @classmethod
    def resume(cls, folder: Path | str, *, case: str, inputs: Inputs | None = None) -> Self:
        """Continue with the rounds in the folder; inputs as for `create`.

        Raises
        ------
        ResultFileError     the rounds belong to another case, or to other inputs, or cannot be read
        """
        archive = cls(folder, case=case, inputs=inputs)
        first = archive.motion(0)
        if first.exists():
            header = read_header(first)
            archive._check_same(header.case, None if inputs is None else header.inputs)
        return archive

    def _check_same(self, case: str, inputs: Inputs | None) -> None:
        """ResultFileError for rounds of another case, or of other inputs if these are given."""
        is_named = self._inputs is not None and inputs is not None
        changed = changes(inputs or {}, self._inputs or {}) if is_named else ""
        if changed or (not is_named and case != self._case):
            raise ResultFileError(
                f"cannot continue {self.folder}: its rounds are of another case"
                f"{f' ({changed})' if changed else ''}; write to another folder, or run the case they were "
                "started with"
            )

    @property
    def is_begun(self) -> bool:
        """Whether the folder contains rounds."""
        return any(self.folder.glob("round-*.npz"))

    def motion(self, number: int) -> Path:
        """Path of the result file of run `number`."""
        return self.folder / f"round-{number}.h5"

    def _bases(self, number: int) -> Path:
        return self.folder / f"round-{number}.npz"

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:
        """Bases stored for a run; ResultFileError where they are damaged or belong to another mesh."""
        path = self._bases(number)
        if not path.exists():
            return None
        with file_errors("read", path):
            try:
                with np.load(io.BytesIO(unsealed(path)), allow_pickle=False) as kept:
                    if "case" in kept:  # older files lack it
                        self._check_same(str(kept["case"]), json.loads(str(kept["inputs"])))
                    bases = {name: _basis(kept, name, full) for name, full in fulls.items()}
                    missed = {
                        name: MissedMotion(
                            float(kept[f"{name}/indicator"]),
                            kept[f"{name}/singular_values"],
                            float(kept[f"{name}/error"]),
                            bool(kept[f"{name}/doubtful"]),
                        )
                        for name in fulls
                        if f"{name}/indicator" in kept
                    }
                    seconds, besides = float(kept["seconds"]), json.loads(str(kept["besides"]))
            except ResultFileError:
                raise
            except (*DAMAGE, BadZipFile) as error:
                raise ResultFileError(f"{path} is damaged ({error}): run the case again") from error
        for name, basis in bases.items():
            if basis.vectors.shape[0] != fulls[name].n_coordinates:
                raise ResultFileError(
                    f"cannot continue {self.folder}: its bases of body '{name}' have "
                    f"{basis.vectors.shape[0]} coordinates and the body has {fulls[name].n_coordinates}; "
                    "write to another folder"
                )
        return RoundBases(bases, missed, seconds, besides)

    def keep_bases(self, number: int, bases: RoundBases) -> None:
        """Write the bases of a run, unless its file exists."""
        path = self._bases(number)
        if path.exists():
            return
        arrays: dict[str, Any] = {"seconds": bases.seconds, "besides": json.dumps(dict(bases.besides))}
        arrays |= {"case": self._case, "inputs": json.dumps(self._inputs and dict(self._inputs))}
        for name, basis in bases.bases.items():
            arrays[f"{name}/vectors"] = basis.vectors
            arrays[f"{name}/report"] = json.dumps(_plain_report(basis.report))
        for name, missed in bases.missed.items():
            arrays[f"{name}/indicator"] = missed.indicator
            arrays[f"{name}/singular_values"] = missed.singular_values
            arrays[f"{name}/error"] = missed.error
            arrays[f"{name}/doubtful"] = missed.doubtful
        image = io.BytesIO()
        np.savez(image, **arrays)
        with replacing(path) as temporary:
            temporary.write_bytes(sealed(image.getvalue()))

    def simulate(self, number: int, system: System, run: Run, *, progress: Progress) -> Solution:
        """Simulate a run or its remainder; read it from its file where it is complete or stopped early."""
        path = self.motion(number)
        stopped = self._stopped(number)
        if stopped.exists():
            check_recorded(system, run, path, case=self._case, inputs=self._inputs)
            with file_errors("read", stopped):
                why = stopped.read_text(encoding="utf-8", errors="replace")
            return replace(read_solution(path), stopped=why)
        solution = simulate_recorded(
            system, run, path, case=self._case, inputs=self._inputs, progress=progress, check=False
        )
        if solution.stopped is not None:
            with replacing(stopped) as temporary:
                temporary.write_text(solution.stopped, encoding="utf-8")
        return solution

    def _stopped(self, number: int) -> Path:
        """Path of the file with the reason why a run ended before its last output time."""
        return self.folder / f"round-{number}.stopped"


def _basis(kept: Mapping[str, np.ndarray], name: str, full: FullBody) -> ReductionBasis:
    words: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value
        for key, value in json.loads(str(kept[f"{name}/report"])).items()
    }
    return ReductionBasis(full.frame, kept[f"{name}/vectors"], ReductionReport(**words))


def _plain_report(report: ReductionReport) -> dict[str, Any]:
    """The mappings and tuples of a report as dictionaries and tuples, for JSON."""
    every = {item.name: getattr(report, item.name) for item in fields(report)}
    return {
        name: dict(value) if isinstance(value, Mapping) else value
        for name, value in every.items()
        if isinstance(value, Mapping | tuple)
    }

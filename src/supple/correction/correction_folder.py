"""A self-correcting reduction that lives on disk: the bases and the motion of every round, as they come.

round-<k>.h5        the motion of run k, a result file (see `storage`)
round-<k>.npz       written before run k starts: per body its basis V and where the columns come from, and
what the run before said of the motion it missed
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, Self

import numpy as np

from supple.body import FullBody
from supple.correction.round_archive import MissedMotion, RoundBases
from supple.errors import ResultFileError
from supple.integrate import Run, Solution
from supple.machine import System
from supple.multibody.run_parts import Progress, Recorder
from supple.reduction import ReductionBasis, ReductionReport
from supple.simulation import simulate
from supple.storage.atomic_write import replacing
from supple.storage.file_errors import file_errors
from supple.storage.result_file import ResultFile
from supple.storage.result_reader import read_header, read_solution


class CorrectionFolder:
    """Keeps the rounds of a self-correction (a `RoundArchive`); the next one reads what the last one kept.

    A round that was finished is read. Computed again are the projections of the bodies on their bases, the
    distances between the runs, and a run that was cut off, from its start: continued in the middle, it would
    have lost the auxiliary acceleration of the time integration, and so would differ from the next run by
    more than their bases.

        self_correct(..., archive=CorrectionFolder.create(folder, case=text))
    """

    def __init__(self, folder: Path | str, *, case: str) -> None:
        self.folder = Path(folder)
        self._case = case

    @classmethod
    def create(cls, folder: Path | str, *, case: str) -> Self:
        """Begin anew, without the rounds that are there.

        Raises
        ------
        ResultFileError     the folder cannot be written
        """
        archive = cls(folder, case=case)
        with file_errors("write", archive.folder):
            archive.folder.mkdir(parents=True, exist_ok=True)
            for pattern in ("round-*.h5", "round-*.npz"):
                for path in archive.folder.glob(pattern):
                    path.unlink()
        return archive

    @classmethod
    def resume(cls, folder: Path | str, *, case: str) -> Self:
        """Go on with the rounds that are there.

        Raises
        ------
        ResultFileError     they belong to another case, or cannot be read
        """
        archive = cls(folder, case=case)
        first = archive.motion(0)
        if first.exists() and read_header(first).case != case:
            raise ResultFileError(
                f"cannot continue {archive.folder}: its rounds are of another case; write to another folder, "
                "or run the case they were started with"
            )
        return archive

    def motion(self, number: int) -> Path:
        """Result file of a run."""
        return self.folder / f"round-{number}.h5"

    def _bases(self, number: int) -> Path:
        return self.folder / f"round-{number}.npz"

    def read_bases(self, number: int, fulls: Mapping[str, FullBody]) -> RoundBases | None:
        """Bases kept for a run; ResultFileError where they are damaged or of another mesh."""
        path = self._bases(number)
        if not path.exists():
            return None
        with file_errors("read", path):
            try:
                with np.load(path, allow_pickle=False) as kept:
                    bases = {name: _basis(kept, name, full) for name, full in fulls.items()}
                    missed = {
                        name: MissedMotion(float(kept[f"{name}/indicator"]), kept[f"{name}/singular_values"])
                        for name in fulls
                        if f"{name}/indicator" in kept
                    }
                    seconds = float(kept["seconds"])
            except (KeyError, ValueError) as error:
                raise ResultFileError(f"{path} is damaged ({error}): run the case again") from error
        for name, basis in bases.items():
            if basis.vectors.shape[0] != fulls[name].n_coordinates:
                raise ResultFileError(
                    f"cannot continue {self.folder}: its bases of body '{name}' have "
                    f"{basis.vectors.shape[0]} coordinates and the body has {fulls[name].n_coordinates}; "
                    "write to another folder"
                )
        return RoundBases(bases, missed, seconds)

    def keep_bases(self, number: int, bases: RoundBases) -> None:
        """Write the bases of a run, unless they were read."""
        path = self._bases(number)
        if path.exists():
            return
        arrays: dict[str, Any] = {"seconds": bases.seconds}
        for name, basis in bases.bases.items():
            arrays[f"{name}/vectors"] = basis.vectors
            arrays[f"{name}/report"] = json.dumps(_plain_report(basis.report))
        for name, missed in bases.missed.items():
            arrays[f"{name}/indicator"] = missed.indicator
            arrays[f"{name}/singular_values"] = missed.singular_values
        with replacing(path) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)

    def simulate(
        self, number: int, system: System, run: Run, *, record: Recorder, progress: Progress
    ) -> None:
        """Run a round, or read it where it is complete."""
        path = self.motion(number)
        if path.exists() and read_header(path).complete:
            record(read_solution(path))
            return

        def keep(chunk: Solution) -> None:
            file.append(chunk)
            record(chunk)

        with ResultFile.create(path, case=self._case) as file:
            simulate(system, run, record=keep, progress=progress)
            file.finish()


def _basis(kept: Mapping[str, np.ndarray], name: str, full: FullBody) -> ReductionBasis:
    words: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value
        for key, value in json.loads(str(kept[f"{name}/report"])).items()
    }
    return ReductionBasis(full.frame, kept[f"{name}/vectors"], ReductionReport(**words))


def _plain_report(report: ReductionReport) -> dict[str, Any]:
    """The labels and seconds of a report."""
    every = {item.name: getattr(report, item.name) for item in fields(report)}
    return {
        name: dict(value) if isinstance(value, Mapping) else value
        for name, value in every.items()
        if isinstance(value, Mapping | tuple)
    }

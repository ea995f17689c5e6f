"""Parts of a sweep on disk: the results of the cases of a share, one sealed HDF5 file per share.

attributes      format, version
cases           (k,) numbers of the cases
status          (k,) `CaseStatus`;  cause (k,) text, "" for a case that ran
seconds         (k,) processor time;  end_time (k,) last time of the run
no_estimate     (k,) text: why there is no error estimate, "" if there is one
estimated_error (k,) total;  basis_error (k,) of the bases;  allowed_error (k,); NaN if unknown
steps, iterations (k,)
statistic       (s,) names of the statistics
statistics      (s, c, k): the values of all cases for one statistic of one channel are contiguous
spectrum        (m, 3) channel, range class, cycles (`FatigueLoads`); without cases that run again
channels/       name, unit, quantity, axes, place: (c,) each
motions/N/      for each case N with a stored motion: channels (t, c), and the arrays of the motion by path
warnings        of the runs, each text once
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from enum import IntEnum
from pathlib import Path

import h5py
import numpy as np

from supple.arrays import FloatArray
from supple.errors import ResultFileError
from supple.storage.sealed_hdf5 import is_whole, open_sealed, writing_sealed
from supple.sweeps.channel_statistics import STATISTICS

FORMAT, VERSION = "supple-sweep-part", 1


class CaseStatus(IntEnum):
    """Status of a case that was run."""

    RAN = 0
    FAILED = 1
    """The run stopped early, or the machine could not be built from the values."""
    KILLED = 2
    """The case killed its process twice."""


@dataclass(frozen=True)
class Channels:
    """Descriptions (c,) of the channels of a case."""

    name: tuple[str, ...] = ()
    unit: tuple[str, ...] = ()
    quantity: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    place: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class CaseRecord:
    """The results of a case.

    no_estimate : why there is no error estimate; "" if there is one
    statistics : (s, c); None for a case that did not run to its end
    spectrum : (m, 3) of its cycles; empty when read from a file, which stores the sum over the part
    motion : stored motion, arrays by path; empty if not stored
    """

    case: int
    status: CaseStatus
    cause: str = ""
    seconds: float = 0.0
    end_time: float = np.nan
    estimated_error: float = np.nan
    basis_error: float = np.nan
    allowed_error: float = np.nan
    no_estimate: str = ""
    steps: int = 0
    iterations: int = 0
    statistics: FloatArray | None = None
    spectrum: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    channels: Channels = field(default_factory=Channels)
    motion: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def lacks_estimate(self) -> bool:
        """Whether the case ran without an error estimate."""
        return self.status is CaseStatus.RAN and bool(np.isnan(self.estimated_error))

    @property
    def needs_richer(self) -> bool:
        """Whether the case ran, with a basis error above the allowed error."""
        return self.status is CaseStatus.RAN and bool(self.basis_error > self.allowed_error)


@dataclass(frozen=True, eq=False)
class Part:
    """The results of a share.

    statistic : names of the statistics;   spectrum : (m, 3), sum over the cases that do not run again
    """

    results: Sequence[CaseRecord]
    warnings: Sequence[str] = ()
    statistic: Sequence[str] = STATISTICS
    spectrum: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))


CHANNEL_KINDS = tuple(each.name for each in fields(Channels))
"""Names of the data sets below `channels/`."""

WORDS = ("cause", "no_estimate")
"""Data sets with a text for each case."""
NUMBERS = {
    "status": np.int8,
    "seconds": np.float64,
    "end_time": np.float64,
    "estimated_error": np.float64,
    "basis_error": np.float64,
    "allowed_error": np.float64,
    "steps": np.int64,
    "iterations": np.int64,
}
"""Data sets with a number for each case, and their types."""

NAMES_OF_RESULTS = frozenset(
    {"case", "channel", "statistic", "statistics", "runs", "fatigue", "lifetime"}
    | {*CHANNEL_KINDS[1:], *WORDS, *NUMBERS}
)
"""Names in the data set of a sweep besides those of the columns of its table."""


def part_path(folder: Path, share: int) -> Path:
    """Path of the part of a share."""
    return folder / "parts" / f"{share:05}.h5"


def write_part(path: Path, part: Part) -> None:
    """Write a part completely; ResultFileError if it cannot be written."""
    results = part.results
    channels = next((each.channels for each in results if each.statistics is not None), Channels())
    numbers = [_statistics_of(each, channels, len(part.statistic)) for each in results]
    with writing_sealed(path) as file:
        file.attrs.update({"format": FORMAT, "version": VERSION})
        _store_words(file, "statistic", part.statistic)
        file.create_dataset("cases", data=np.array([each.case for each in results], dtype=np.int64))
        for name, kind in NUMBERS.items():
            file.create_dataset(name, data=np.array([getattr(each, name) for each in results], dtype=kind))
        for name in WORDS:
            _store_words(file, name, [getattr(each, name) for each in results])
        _store_words(file, "warnings", part.warnings)
        file.create_dataset("statistics", data=np.stack(numbers, axis=-1))
        file.create_dataset("spectrum", data=part.spectrum)
        for name, words in vars(channels).items():
            _store_words(file, f"channels/{name}", words)
        for each in results:
            for where, array in each.motion.items():
                file.create_dataset(f"motions/{each.case}/{where}", data=array, compression=1, shuffle=True)


def _statistics_of(result: CaseRecord, channels: Channels, number: int) -> FloatArray:
    """Statistics (s, c) of a case; NaN if it has none, or if its channels are not those of the part."""
    if result.statistics is None or result.channels != channels:
        return np.full((number, len(channels.name)), np.nan)
    return result.statistics


def _store_words(file: h5py.File, name: str, words: Sequence[str]) -> None:
    file.create_dataset(name, data=list(words), shape=(len(words),), dtype=h5py.string_dtype())


def read_part(path: Path) -> Part:
    """Read a part; ResultFileError if it is missing or damaged."""
    with open_sealed(path) as file:
        if file.attrs.get("format") != FORMAT or int(file.attrs["version"]) > VERSION:
            raise ResultFileError(
                f"{path} is no part of a sweep, or a newer version wrote it: update supple, or run the sweep "
                "again"
            )
        channels = Channels(**{name: tuple(file[f"channels/{name}"].asstr()[()]) for name in CHANNEL_KINDS})
        columns = {name: file[name][()] for name in NUMBERS}
        words, statistics = {name: file[name].asstr()[()] for name in WORDS}, file["statistics"][()]
        results = []
        for row, case in enumerate(file["cases"][()].tolist()):
            known = {name: column[row].item() for name, column in columns.items()}
            known |= {name: column[row] for name, column in words.items()}
            known["status"] = status = CaseStatus(known["status"])
            own = statistics[..., row] if status is CaseStatus.RAN else None
            motion = motion_in(file, case)
            results.append(CaseRecord(case, **known, statistics=own, channels=channels, motion=motion))
        warned, names = (tuple(file[name].asstr()[()]) for name in ("warnings", "statistic"))
        return Part(results, warned, names, file["spectrum"][()])


def motion_in(file: h5py.File, case: int) -> dict[str, FloatArray]:
    """The arrays of a stored motion by path; empty if none is stored."""
    found: dict[str, FloatArray] = {}
    group = file.get(f"motions/{case}")
    if isinstance(group, h5py.Group):
        group.visititems(
            lambda name, own: found.update({name: own[()]}) if isinstance(own, h5py.Dataset) else None
        )
    return found


def whole_parts(folder: Path, n_shares: int) -> list[int]:
    """Numbers of the shares whose parts exist and are complete."""
    return [share for share in range(n_shares) if is_whole(part_path(folder, share))]

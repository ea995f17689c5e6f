"""The plan of a sweep: its cases, their groups, and the shares that are the tasks.

The plan is stored once, in `plan.h5` in the folder of the sweep. Every process reads it: a task is the folder
and the number of a share. Shares depend on the table only, not on the number of cores, so that the digits of
the results do not depend on where a sweep runs.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from supple.arrays import IntArray
from supple.cases.case_family import CaseFamily, case_family
from supple.cases.case_inputs import digests_of_files, missing_files
from supple.cases.parameter_path import parameter_path
from supple.cases.result_machine import path_from
from supple.errors import CaseError, ResultFileError
from supple.importers.toml import KeyPath, Raw
from supple.storage.file_seal import seal_of
from supple.storage.run_inputs import Inputs, changes, digest_of
from supple.storage.sealed_hdf5 import open_sealed, writing_sealed
from supple.sweeps.body_numbers import DAMPING_NUMBERS, is_number_of_run
from supple.sweeps.case_table import CaseTable
from supple.sweeps.fatigue_loads import planned_channels
from supple.sweeps.part_file import NAMES_OF_RESULTS
from supple.sweeps.sweep_file import SweepOutput
from supple.units import UnitSystem

__all__ = ["SweepPlan", "make_plan", "plan_path", "read_plan", "write_plan"]

FORMAT, VERSION = "supple-sweep-plan", 1
LARGEST_SHARE = 512
"""Largest default number of cases of a share."""
FEWEST_SHARES = 64
"""Smallest number of shares, if there are enough cases, so that many cores have work."""
MARCHED_AT_ONCE = 16
"""Number of cases in a call of the compiled program, and in the smallest share."""


def _time_of(start: object) -> float:
    """Start time of a run by `simulation.start`: that of a state of an earlier run, otherwise 0."""
    return float(start["time"]) if isinstance(start, Mapping) else 0.0


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """The plan of a sweep.

    case_file : path of the case file (`plan.h5` has it relative to its folder);  case_text : its text
    table : table of the cases;  places : keys in the case file by column, without labels
    group : (n,) group of each case; cases of one group have the same bodies, run and program
    share : (n,) share of each case; a share is a part of one group
    inputs : digests of all inputs, by name
    allow_code : whether controllers of the case may run; given with each task, never read from a folder
    """

    case_file: Path
    case_text: str
    table: CaseTable
    places: Mapping[str, KeyPath]
    group: IntArray
    share: IntArray
    output: SweepOutput
    inputs: Inputs
    units: UnitSystem
    allow_code: bool = False

    @cached_property
    def digest(self) -> str:
        """Short digest of all inputs."""
        return digest_of(json.dumps(dict(self.inputs), sort_keys=True).encode()).partition(":")[2][:16]

    @property
    def n_cases(self) -> int:
        """Number of cases."""
        return len(self.share)

    @property
    def n_shares(self) -> int:
        """Number of shares."""
        return int(self.share.max()) + 1

    def cases_of(self, share: int) -> IntArray:
        """Numbers of the cases of a share, ascending."""
        return np.flatnonzero(self.share == share)

    def values(self, case: int) -> dict[KeyPath, Any]:
        """The values of a case that replace those of the case file, by place."""
        row = self.table.row(case)
        return {place: row[path] for path, place in self.places.items()}

    @property
    def start_times(self) -> NDArray[np.float64]:
        """Start times (n,) of the cases: 0, or the times of the states that they continue."""
        found = np.full(self.n_cases, _time_of(tomllib.loads(self.case_text)["simulation"].get("start")))
        for path, place in self.places.items():
            column = self.table.columns[path]
            if place == ("simulation", "start"):
                found[:] = [_time_of(start) for start in column]
            elif place == ("simulation", "start", "time"):
                found[:] = column
        return found

    def representatives(self, group: int) -> IntArray:
        """The cases of a group; the bodies of the first valid one are reduced for all cases.

        Those with the largest value in the first damping column come first; the next columns decide among
        equal values. Damping ratios are scaled for the other cases; a ratio of zero is zero in all cases.
        """
        cases = np.flatnonzero(self.group == group)
        damping = [
            np.asarray(self.table.columns[path], dtype=float)[cases]
            for path, place in self.places.items()
            if place[0] == "body" and place[-1] in DAMPING_NUMBERS
        ]
        return cases[np.lexsort([-own for own in reversed(damping)])] if damping else cases

    def keeps(self, case: int) -> bool:
        """Whether the motion of a case is stored."""
        keep = self.output.keep
        return keep == "all" or (keep != "none" and case in self._kept)

    @cached_property
    def _kept(self) -> frozenset[int]:
        return frozenset(number for number in self.output.keep if isinstance(number, int))

    @cached_property
    def family(self) -> CaseFamily:
        """The case file; CaseError if it was changed since the sweep was planned."""
        family = case_family(self.case_file)
        if family.text != self.case_text:
            raise CaseError(
                f"{self.case_file} was changed since the sweep was planned: run it again with --force"
            )
        return family


def plan_path(folder: Path) -> Path:
    """Path of the plan in a folder."""
    return folder / "plan.h5"


def make_plan(
    case_file: Path,
    table: CaseTable,
    output: SweepOutput,
    texts: Mapping[str, str] | None = None,
    *,
    allow_code: bool = False,
) -> SweepPlan:
    """The plan of a table of cases; equal inputs give equal plans.

    texts : texts of other input files, by name
    allow_code : run the Python file of `control`, if the case names one

    Raises
    ------
    CaseError   a path that does not exist, or whose last key no case can have, or of the units; two paths to
                one value; a controller without `allow_code`, or together with a requested accuracy; an
                unknown case in `keep`; unknown channels, nodes or wind speed in `output.fatigue`; a sensor
                that cannot be built
    """
    family = case_family(case_file)
    family.case.check_control(allow_code=allow_code)
    if not len(table):
        raise CaseError("a sweep needs at least one case: give values in the table")
    if isinstance(output.keep, tuple) and (beyond := [each for each in output.keep if each >= len(table)]):
        raise CaseError(f"keep has case {beyond[0]}, but the cases are 0 to {len(table) - 1}")
    if output.fatigue is not None:
        output.fatigue.check(family.case, table)
    _check_columns(table, output, family.raw)
    places = {path: parameter_path(path, family.raw) for path in table.columns if path not in output.labels}
    _check_places(places)
    if family.case.tables.sensor and not any(place[0] == "sensor" for place in places.values()):
        planned_channels(family.case)  # a sensor that cannot be built would fail in every case
    _check_last_keys(family, table, places)
    finds_modes = _finds_modes(family.raw, places.values())
    apart = [
        path
        for path, place in places.items()
        if finds_modes or not all(is_number_of_run(place, value, family.raw) for value in table.columns[path])
    ]
    keys = [list(map(repr, table.columns[path])) for path in apart]
    ratios = [
        path
        for path, place in places.items()
        if path not in apart and place[0] == "body" and place[-2:] == ("damping", "ratio")
    ]
    if len(ratios) > 1:
        # The damping of one case is scaled for all cases of a group: a ratio is zero in all cases or in none.
        keys += [[value == 0 for value in table.columns[path]] for path in ratios]
    group = numbered(list(zip(*keys, strict=True)), len(table))
    share = _shares(group, output.cases_per_share)
    inputs = _inputs(family, table, places) | {
        name: digest_of(text.encode()) for name, text in (texts or {}).items()
    }
    inputs |= {"what is kept": output.model_dump_json()}
    units = family.case.units
    return SweepPlan(
        case_file.resolve(), family.text, table, places, group, share, output, inputs, units, allow_code
    )


def _check_columns(table: CaseTable, output: SweepOutput, raw: Raw) -> None:
    """CaseError for labels and seeds that are no columns, and for labels named as a path or a result."""
    for name in output.labels:
        if name in NAMES_OF_RESULTS:
            raise CaseError(f"labels: {name!r} is the name of a result (read_sweep): rename the column")
        if _stands(name, raw):
            raise CaseError(
                f"labels: {name!r} is a path of the case file, so that the column varies it: remove the label"
            )
    for what, names in (("labels", output.labels), ("seeds", output.seeds)):
        for name in names:
            table.check_has(name, f"{what}: ")


def _check_places(places: Mapping[str, KeyPath]) -> None:
    """CaseError for a column that replaces the value of an earlier one in every case, or varies the units."""
    for path, place in places.items():
        if place[0] == "units":
            raise CaseError(
                f"{path}: the units only name the numbers, and a sweep states them once for all cases: "
                "remove the column"
            )
    for (one, first), (other, second) in combinations(places.items(), 2):
        if first[: len(second)] == second:
            raise CaseError(f"{other} replaces the value that {one} varies: keep one of the columns")


def _check_last_keys(family: CaseFamily, table: CaseTable, places: Mapping[str, KeyPath]) -> None:
    """CaseError for a column whose last key no case can have, such as a misspelt key with a default."""
    texts = [path for path in places if any(map(_has_text, table.columns[path]))]  # they may choose a kind
    rows = {repr([table.columns[path][case] for path in texts]): case for case in reversed(range(len(table)))}
    unknown: dict[KeyPath, str] | None = None
    for case in reversed(rows.values()):
        found = family.unknown_keys({place: table.columns[path][case] for path, place in places.items()})
        unknown = found if unknown is None else {key: unknown[key] for key in unknown.keys() & found.keys()}
        if not unknown:
            return
    for path, place in places.items():
        if unknown and place in unknown:
            raise CaseError(f"{path}: {unknown[place]}")


def _finds_modes(raw: Raw, places: Iterable[KeyPath]) -> bool:
    """Whether trial runs determine the number of modes of a condensed body; cases then share no group."""
    given = [body["condense"] for body in raw["body"] if "condense" in body]
    return any("accuracy" in own for own in given) or any(
        place[2:4] == ("condense", "accuracy") for place in places
    )


def _stands(path: str, raw: Raw) -> bool:
    """Whether the case file has a value at a path."""
    try:
        place = parameter_path(path, raw)
    except CaseError:
        return False
    *outer, last = place
    found: Any = raw
    for key in outer:
        found = found[key]
    return isinstance(found, list) or (isinstance(found, Mapping) and last in found)


def numbered(keys: Sequence[Hashable], n: int) -> IntArray:
    """Numbers (n,) of keys, from 0 in order of appearance; all 0 without keys."""
    numbers: dict[Hashable, int] = {}
    found = [numbers.setdefault(key, len(numbers)) for key in keys]
    return np.array(found, dtype=np.int64) if found else np.zeros(n, dtype=np.int64)


def _shares(group: IntArray, size: int | None) -> IntArray:
    """Share of each case; the default size is a multiple of `MARCHED_AT_ONCE`."""
    if size is None:
        even = -(-len(group) // FEWEST_SHARES)
        size = min(-(-even // MARCHED_AT_ONCE) * MARCHED_AT_ONCE, LARGEST_SHARE)
    share, begun = np.empty(len(group), dtype=np.int64), 0
    for own in range(int(group.max()) + 1):
        cases = np.flatnonzero(group == own)
        share[cases] = begun + np.arange(len(cases)) // size
        begun = int(share[cases[-1]]) + 1
    return share


def _inputs(family: CaseFamily, table: CaseTable, places: Mapping[str, KeyPath]) -> dict[str, str]:
    """Digests of all inputs by name: the text of the case, the table, and all files that any case reads.

    A missing file is an input as well: its cases fail, and must run again if the file exists later.
    """
    files = set(family.files({}))
    for path, place in places.items():
        for value in {repr(own): own for own in table.columns[path] if _has_text(own)}.values():
            files |= set(family.files({place: value}))
    text = json.dumps({path: list(column) for path, column in table.columns.items()})
    found = {"the case": digest_of(family.text.encode()), "the table": digest_of(text.encode())}
    if family.raw.get("machine"):  # its file may include others; the tables contain all data used
        found["the machine"] = digest_of(repr(family.raw).encode())
    folder = family.path.parent
    return found | missing_files(sorted(files), folder) | digests_of_files(sorted(files), folder)


def _has_text(value: object) -> bool:
    """Whether a value may name a file: a text, or a table or list with texts."""
    if isinstance(value, Mapping):
        return any(map(_has_text, value.values()))
    return isinstance(value, str) or (isinstance(value, list) and any(map(_has_text, value)))


def write_plan(folder: Path, plan: SweepPlan) -> None:
    """Write the plan completely; ResultFileError if it cannot be written."""
    with writing_sealed(plan_path(folder)) as file:
        file.attrs.update(
            {
                "format": FORMAT,
                "version": VERSION,
                "case_file": path_from(folder, plan.case_file),
                "case": plan.case_text,
                "output": plan.output.model_dump_json(),
                "inputs": json.dumps(dict(plan.inputs)),
                "units": str(plan.units),
                "paths": json.dumps(list(plan.table.columns)),
                "places": json.dumps([plan.places.get(path) for path in plan.table.columns]),
            }
        )
        file.create_dataset("group", data=plan.group)
        file.create_dataset("share", data=plan.share)
        for number, column in enumerate(plan.table.columns.values()):
            _store_column(file, f"parameters/{number}", column)


def _store_column(file: h5py.File, name: str, column: Sequence[Any]) -> None:
    """Store a column: numbers as an array, other values as JSON."""
    numbers = {type(value) for value in column}
    if numbers <= {float} or numbers <= {int}:
        file.create_dataset(name, data=np.array(column))
    else:
        file.create_dataset(name, data=[json.dumps(value) for value in column], dtype=h5py.string_dtype())


def _read_column(dataset: h5py.Dataset) -> Sequence[Any]:
    if dataset.dtype.kind in "fi":
        return dataset[()].tolist()
    return [json.loads(text) for text in dataset.asstr()[()]]


def read_plan(folder: Path, *, allow_code: bool = False) -> SweepPlan:
    """The plan in a folder; ResultFileError if there is none.

    allow_code : whether controllers of its case may run
    """
    path = plan_path(folder)
    if not path.is_file():
        raise ResultFileError(f"{folder} has no sweep (no plan.h5); check the path")
    return _plan(path, seal_of(path), allow_code)


@lru_cache(maxsize=4)
def _plan(path: Path, _: bytes, allow_code: bool) -> SweepPlan:
    """The plan in a file, cached by the seal of the file, so that a new plan is read again."""
    folder = path.parent
    with open_sealed(path) as file:
        known = file.attrs
        if known.get("format") != FORMAT or int(known["version"]) > VERSION:
            raise ResultFileError(
                f"{path} is no plan of a sweep, or a newer version wrote it: use that version"
            )
        paths = json.loads(known["paths"])
        columns = {name: _read_column(file[f"parameters/{i}"]) for i, name in enumerate(paths)}
        places = {
            name: tuple(place)
            for name, place in zip(paths, json.loads(known["places"]), strict=True)
            if place is not None
        }
        return SweepPlan(
            (folder / known["case_file"]).resolve(),
            known["case"],
            CaseTable(columns),
            places,
            file["group"][()],
            file["share"][()],
            SweepOutput.model_validate_json(known["output"]),
            json.loads(known["inputs"]),
            UnitSystem.parsed(known["units"]),
            allow_code,
        )


def changed_inputs(there: SweepPlan, here: SweepPlan) -> str:
    """Differences between the inputs of two plans, as text; empty if there are none."""
    return changes(there.inputs, here.inputs)

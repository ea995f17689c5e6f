"""The bodies of a group of cases, reduced once and stored under a digest of their inputs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from supple import __version__
from supple.body import Damping, LinearRayleighDamping, RayleighDamping
from supple.cases.bodies import Body
from supple.cases.case import Case
from supple.cases.case_inputs import digests_of_files
from supple.cases.damping import RayleighRatio
from supple.cases.reductions import FullOrder
from supple.cases.static_case import starting_system
from supple.cases.table import named_in
from supple.error import Round, correction_numbers, self_correct
from supple.integrate import Validity
from supple.machine import System
from supple.reduction import ReducedBody, redamped
from supple.simulation import store_body
from supple.simulation.stored_bodies import stored_path
from supple.storage import read_reduced_body, write_json
from supple.storage.exclusive_lock import ExclusiveLock
from supple.storage.file_errors import file_errors
from supple.storage.run_inputs import digest_of
from supple.storage.sealed_hdf5 import is_whole
from supple.sweeps.body_numbers import PLACING

FORMAT = 1
"""Version of stored reductions; other versions are not read."""
_RECORD = "reductions.json"


@dataclass(frozen=True, eq=False)
class GroupBodies:
    """The reduced bodies of a group of cases.

    reduced : bodies by name, with the damping of the representative case
    rayleigh : alpha and beta of Rayleigh damping in the representative case, by body; a damping ratio is
        converted with the frequencies of the body before reduction
    tables : tables of these bodies in the representative case
    """

    reduced: Mapping[str, ReducedBody]
    rayleigh: Mapping[str, tuple[float, float]]
    tables: Mapping[str, Body]

    def damped(self, name: str, table: Body) -> ReducedBody:
        """A reduced body with the damping of a case."""
        body, like = self.reduced[name], self.tables[name]
        if table.damping == like.damping:
            return body
        before, after = self.damping(name, like), self.damping(name, table)
        assert before is not None
        assert after is not None
        return redamped(body, before, after)

    def damping(self, name: str, table: Body) -> Damping | None:
        """The damping of a body in a case; None without damping."""
        given: Any = table.damping
        if not isinstance(given, RayleighRatio):
            return None if given is None else given.build()
        like: Any = self.tables[name].damping
        share = given.ratio / like.ratio if like.ratio else 0.0
        alpha, beta = (share * factor for factor in self.rayleigh[name])
        kind = RayleighDamping if given.kind == "rayleigh-ratio" else LinearRayleighDamping
        return kind(alpha, beta, given.held)


def bodies_of_group(case: Case, folder: Path) -> GroupBodies:
    """The reduced bodies of a case, read from the folder of the sweep, or reduced and stored there.

    If another process is reducing the bodies, this process waits.

    Raises errors of reductions; SelfCorrectionError if an accuracy is not met.
    """
    tables = {table.name: table for table in case.parts.body if is_reduced_here(table)}
    if not tables:
        return GroupBodies({}, {}, {})
    own = folder / "bodies" / _digest(case, tables)
    with file_errors("make the folder", own):
        own.mkdir(parents=True, exist_ok=True)
    if not _are_kept(own, tables):
        with ExclusiveLock(own, wait=True):
            if not _are_kept(own, tables):
                _reduce(case, tables, own)
    record = json.loads((own / _RECORD).read_text(encoding="utf-8"))
    reduced = {name: read_reduced_body(stored_path(own, name)) for name in tables}
    return GroupBodies(reduced, {name: tuple(own) for name, own in record["rayleigh"].items()}, tables)


def is_reduced_here(table: Body) -> bool:
    """Whether the sweep reduces a body from its elements."""
    return (
        table.elastic is not None
        and table.condense is None
        and not table.is_explicit
        and not isinstance(table.reduction, FullOrder)
    )


def _digest(case: Case, tables: Mapping[str, Body]) -> str:
    """Digest of all inputs of the reductions; with self-correction, these are all inputs of the case."""
    if case.starts:
        content: dict[str, object] = {key: str(value) for key, value in case.inputs.items()}
    else:
        named = [name for table in tables.values() for name in _files(table)]
        bodies = [table.model_dump(mode="json", exclude=set(PLACING)) for table in case.tables.body]
        content = {"bodies": bodies, "files": digests_of_files(named, case.folder)}
    text = json.dumps([FORMAT, __version__, content], sort_keys=True)
    return digest_of(text.encode()).partition(":")[2][:16]


def _files(table: Body) -> list[str]:
    """Names of the files of a body."""
    given = named_in(Body, table.model_dump(mode="json"))
    return [name for _, name, what in given if what == "file" and isinstance(name, str)]


def _are_kept(folder: Path, tables: Mapping[str, Body]) -> bool:
    return (folder / _RECORD).is_file() and all(is_whole(stored_path(folder, name)) for name in tables)


def _reduce(case: Case, tables: Mapping[str, Body], folder: Path) -> None:
    """Reduce the bodies of a case and store them; the record is written last."""
    rounds: list[Round] = []
    system: System = case.system
    if case.starts:
        run = replace(case.run, validity=Validity())
        corrected = self_correct(starting_system(case), run, case.starts, announce=rounds.append)
        system = corrected.system
    found = system.bodies_of(ReducedBody)
    rayleigh = {}
    for name in tables:
        body = found[name]
        store_body(body, folder)
        damping = body.full.damping if body.full is not None else None
        if isinstance(damping, RayleighDamping | LinearRayleighDamping):
            rayleigh[name] = (damping.alpha, damping.beta)
    write_json(folder / _RECORD, {"rayleigh": rayleigh, "rounds": correction_numbers(rounds)})

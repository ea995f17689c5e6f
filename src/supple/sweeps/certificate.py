"""What is known of the errors of the cases of a group: from a few statements, by an indicator of every case.

Of representative cases the error is stated as of single runs; over their indicators it gives the effectivity,
the largest of which scales the indicator of every case (docs/theory/greedy_certification.md).

    estimated = effectivity * indicator + share * size,      size: largest displacement of the case

with the share that the other parts of the statements (step, Newton, model) have of the sizes there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from supple.body import FullBody
from supple.error import Indicated, IndicatorBody
from supple.error.correction_rounds import SelfCorrection
from supple.error.equation import ErrorSpace, MotionColumns
from supple.storage.sealed_hdf5 import open_sealed, writing_sealed

__all__ = ["Certificate", "EstimatedError", "Representative", "read_certificate", "write_certificate"]

NOTHING = 1e-9
"""Of the displacement: a stated error that is less has no effectivity."""


@dataclass(frozen=True)
class Representative:
    """A case whose error was stated; lengths, of one body.

    basis : error by the basis that was stated;  others : by step, Newton's iteration and model together
    indicator : found before the motion that this case misses joined its columns
    final : the same with the columns as they were in the end
    size : largest displacement
    """

    case: int
    body: str
    basis: float
    others: float
    indicator: float
    final: float
    size: float

    @property
    def ratios(self) -> tuple[float, ...]:
        """Stated error over the indicators that are known."""
        if not self.basis > NOTHING * self.size:
            return ()
        return tuple(self.basis / each for each in (self.indicator, self.final) if np.isfinite(each) and each)


class EstimatedError(NamedTuple):
    """Estimated error of a case, a length: of the body whose error is largest beside what it is allowed.

    estimated : by all parts;  basis : by the basis alone;  allowed : NaN where no accuracy is asked for
    """

    estimated: float = np.nan
    basis: float = np.nan
    allowed: float = np.nan


@dataclass(frozen=True, eq=False)
class Certificate:
    """Of the cases of a group.

    bodies : whose bases are assessed, with the columns of their indicators
    representatives : of these bodies, statement by statement
    targets : the error to reach, of those that correct themselves
    reason : why there is no estimate; empty where there is one
    """

    bodies: Mapping[str, IndicatorBody] = field(default_factory=dict)
    representatives: Sequence[Representative] = ()
    targets: Mapping[str, SelfCorrection] = field(default_factory=dict)
    reason: str = ""

    def effectivity(self, body: str) -> float:
        """Largest ratio of a stated error to its indicator; 1 where all errors are nothing."""
        return max((ratio for each in self._of(body) for ratio in each.ratios), default=1.0)

    def spread(self, body: str) -> float:
        """Largest of these ratios over the smallest."""
        ratios = [ratio for each in self._of(body) for ratio in each.ratios]
        return max(ratios) / min(ratios) if ratios else 1.0

    def other_share(self, body: str) -> float:
        """Of the size: the other parts of the error."""
        return max((each.others / each.size for each in self._of(body) if each.size), default=0.0)

    def case_error(self, indicated: Mapping[str, Indicated]) -> EstimatedError:
        """Of a case from its indicators."""
        if self.reason or not indicated:
            return EstimatedError()
        found = []
        for name, own in indicated.items():
            basis = self.effectivity(name) * own.error
            allowed = self.allowed(name, own.size)
            found.append(EstimatedError(basis + self.other_share(name) * own.size, basis, allowed))
        return max(found, key=lambda each: (each.basis / (each.allowed or np.nan) > 1, each.estimated))

    def allowed(self, body: str, size: float) -> float:
        """The error that a body may have; NaN without an accuracy, or with one of another quantity."""
        target = self.targets.get(body)
        return np.nan if target is None or target.of is not None else target.allowed(size)

    def _of(self, body: str) -> list[Representative]:
        return [each for each in self.representatives if each.body == body]


def write_certificate(path: Path, certificate: Certificate) -> None:
    """Write it whole; ResultFileError where it cannot be written."""
    with writing_sealed(path) as file:
        file.attrs["reason"] = certificate.reason
        file.attrs["representatives"] = json.dumps([asdict(each) for each in certificate.representatives])
        for name, body in certificate.bodies.items():
            own = file.create_group(f"bodies/{name}")
            own.attrs["n_motion"] = body.space.n_motion
            own.create_dataset("columns", data=body.space.vectors)
            if body.columns.following is not None:
                own.create_dataset("following", data=body.columns.following)
                own.create_dataset("rigid", data=body.columns.rigid)


def read_certificate(
    path: Path, fulls: Mapping[str, FullBody], targets: Mapping[str, SelfCorrection]
) -> Certificate:
    """That of a file; ResultFileError where it is damaged."""
    with open_sealed(path) as file:
        rows = [Representative(**each) for each in json.loads(file.attrs["representatives"])]
        bodies = {name: _body(file[f"bodies/{name}"], fulls[name]) for name in file.get("bodies", ())}
        return Certificate(bodies, rows, targets, file.attrs["reason"])


def _body(file: h5py.Group, full: FullBody) -> IndicatorBody:
    vectors, n_motion = file["columns"][()], int(file.attrs["n_motion"])
    following, rigid = (file[name][()] if name in file else None for name in ("following", "rigid"))
    columns = MotionColumns(vectors[:, :n_motion], following, rigid)
    return IndicatorBody(full, columns, ErrorSpace(vectors, n_motion))

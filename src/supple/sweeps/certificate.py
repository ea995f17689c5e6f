"""Estimated errors of the cases of a group: full estimates of a few cases, and an indicator of every case.

The error of representative cases is estimated in full, as for single runs. The effectivity is the largest
ratio of an estimated basis error to its indicator; it scales the indicators of all cases
(docs/theory/greedy_certification.md):

    estimated = effectivity * indicator + share * size,      size: largest displacement of the case

The share is the largest ratio of the other errors of a representative case (step, Newton, model) to its size.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from supple.body import FullBody
from supple.error import ErrorIndicator, IndicatorBody
from supple.error.correction_rounds import SelfCorrection
from supple.error.equation import ErrorSpace, MotionColumns
from supple.storage.sealed_hdf5 import open_sealed, writing_sealed

NOTHING = 1e-9
"""Ratio of basis error to largest displacement up to which the error is negligible for the effectivity."""


@dataclass(frozen=True)
class Representative:
    """The full error estimate of one body in one case; errors and size are lengths.

    basis : estimated error of the basis
    others : estimated error of step, Newton's iteration and model together
    indicator : indicator before its columns included the motion that the basis lacks in this case
    final : indicator with the final columns
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
        """Ratios of the estimated basis error to the known indicators; none for a negligible error."""
        if not self.basis > NOTHING * self.size:
            return ()
        return tuple(self.basis / each for each in (self.indicator, self.final) if np.isfinite(each) and each)


class EstimatedError(NamedTuple):
    """Estimated error of the worst body of a case, a length.

    The worst body is the body with the largest ratio of basis error to allowed error; if no ratio exceeds
    one, the body with the largest estimated total error.

    estimated : total error;  basis : error of the basis;  allowed : NaN without a requested accuracy
    """

    estimated: float = np.nan
    basis: float = np.nan
    allowed: float = np.nan

    @property
    def ratio(self) -> float:
        """Basis error divided by the allowed error; 0 without a requested accuracy."""
        return self.basis / self.allowed if self.allowed > 0 else 0.0


@dataclass(frozen=True, eq=False)
class Certificate:
    """The data from which errors of the cases of a group are estimated.

    bodies : bodies whose bases are assessed, with the columns of their indicators
    representatives : full estimates of these bodies, in the order of the cases
    targets : accuracies of the bodies with self-correction
    reason : why there is no estimate; empty if there is one
    """

    bodies: Mapping[str, IndicatorBody] = field(default_factory=dict)
    representatives: Sequence[Representative] = ()
    targets: Mapping[str, SelfCorrection] = field(default_factory=dict)
    reason: str = ""

    @property
    def why_no_estimate(self) -> str:
        """Why a case that ran has no estimate of its total error."""
        if not self.reason and any(np.isnan(each.others) for each in self.representatives):
            return (
                "the error of the step or of the model is not estimated, only that of the basis: remove "
                "integration = false and model = false from [error]"
            )
        return self.reason or "the error indicator could not be computed"

    def effectivity(self, body: str) -> float:
        """Largest ratio of an estimated basis error to its indicator; 1 if all errors are negligible."""
        return max((ratio for each in self._of(body) for ratio in each.ratios), default=1.0)

    def spread(self, body: str) -> float:
        """Ratio of the largest to the smallest of the ratios in `effectivity`."""
        ratios = [ratio for each in self._of(body) for ratio in each.ratios]
        return max(ratios) / min(ratios) if ratios else 1.0

    def other_share(self, body: str) -> float:
        """Largest ratio of the errors of step, Newton and model together to the largest displacement."""
        return max((each.others / each.size for each in self._of(body) if each.size), default=0.0)

    def case_error(self, case: int, indicated: Mapping[str, ErrorIndicator]) -> EstimatedError:
        """Estimated error of a case: full estimates of a representative case, otherwise `scaled_indicator`.

        indicated : indicators of the case, by body
        """
        full = {each.body: each for each in self.representatives if each.case == case}
        if self.reason or not full or full.keys() != indicated.keys():
            return self.scaled_indicator(indicated)
        return _of_worst(
            EstimatedError(each.basis + each.others, each.basis, self.allowed(name, indicated[name].size))
            for name, each in full.items()
        )

    def scaled_indicator(self, indicated: Mapping[str, ErrorIndicator]) -> EstimatedError:
        """Estimated error of a case from its indicators by body; NaN without indicators or with `reason`."""
        if self.reason or not indicated:
            return EstimatedError()
        found = []
        for name, own in indicated.items():
            basis = self.effectivity(name) * own.error
            others = self.other_share(name) * own.size
            found.append(EstimatedError(basis + others, basis, self.allowed(name, own.size)))
        return _of_worst(found)

    def allowed(self, body: str, size: float) -> float:
        """Allowed error of a body; NaN without an accuracy, or if its accuracy is for another quantity."""
        target = self.targets.get(body)
        return np.nan if target is None or target.of is not None else target.allowed(size)

    def _of(self, body: str) -> list[Representative]:
        return [each for each in self.representatives if each.body == body]


def _of_worst(bodies: Iterable[EstimatedError]) -> EstimatedError:
    return max(bodies, key=lambda each: (max(each.ratio, 1.0), each.estimated))


def write_certificate(path: Path, certificate: Certificate) -> None:
    """Write a certificate; ResultFileError if the file cannot be written."""
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
    """The certificate in a file; ResultFileError if it is damaged."""
    with open_sealed(path) as file:
        rows = [Representative(**each) for each in json.loads(file.attrs["representatives"])]
        bodies = {name: _body(file[f"bodies/{name}"], fulls[name]) for name in file.get("bodies", ())}
        return Certificate(bodies, rows, targets, file.attrs["reason"])


def _body(file: h5py.Group, full: FullBody) -> IndicatorBody:
    vectors, n_motion = file["columns"][()], int(file.attrs["n_motion"])
    following, rigid = (file[name][()] if name in file else None for name in ("following", "rigid"))
    columns = MotionColumns(vectors[:, :n_motion], following, rigid)
    return IndicatorBody(full, columns, ErrorSpace(vectors, n_motion))

"""Numbers of a case file as parameters of its machine: derivatives of its outputs, fits to measurements."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any
from weakref import WeakKeyDictionary

from supple.arguments import checked_arguments
from supple.cases.case_family import case_family
from supple.errors import CaseError, did_you_mean
from supple.integrate import Run
from supple.machine import System
from supple.quantities import Quantity
from supple.sensitivity import Calibration, Measurement, Sensitivities, calibrate, sensitivities
from supple.sweeps.body_numbers import number_of_run
from supple.sweeps.case_table import CaseTable
from supple.sweeps.plan import make_plan
from supple.sweeps.sweep_file import SweepOutput
from supple.sweeps.swept_group import SweptCase, SweptGroup, swept_group

__all__ = ["CaseParameters", "case_parameters"]


@dataclass(frozen=True, eq=False)
class CaseParameters:
    """Some numbers of a case, whose bodies are reduced once for all their values.

    values : of the case file, by path
    """

    values: Mapping[str, float]
    _group: SweptGroup
    _cases: WeakKeyDictionary[System, SweptCase] = field(default_factory=WeakKeyDictionary)

    @property
    def run(self) -> Run:
        """Of the case."""
        return self._group.like.run

    def machine(self, values: Mapping[str, float]) -> System:
        """The machine as its run starts, with other values by path; errors as of reading a case file."""
        places = self._group.plan.places
        found = self._group.with_values({places[path]: value for path, value in values.items()})
        self._cases[found.system] = found
        return found.system

    def sensitivities(
        self, outputs: Sequence[str], *, sizes: Mapping[str, float] = MappingProxyType({})
    ) -> Sensitivities:
        """Derivatives of outputs of the case for its parameters, along the run.

        outputs : names of its sensors, `joint NAME`, `position BODY.PLACE`, `deflection BODY.PLACE`, `energy`
        sizes, results, errors : as of `supple.sensitivity.sensitivities`
        """
        return sensitivities(self.machine, self.values, self.run, self._named(outputs), sizes=sizes)

    def calibrate(
        self,
        measurements: Sequence[Measurement],
        *,
        bounds: Mapping[str, tuple[float, float]] = MappingProxyType({}),
        sizes: Mapping[str, float] = MappingProxyType({}),
    ) -> Calibration:
        """Values of the parameters that fit measurements of outputs, beginning with those of the case file.

        measurements : each `observable` an output, as for `sensitivities`
        bounds, sizes, results, errors : as of `supple.sensitivity.calibrate`
        """
        outputs = list(dict.fromkeys(each.observable for each in measurements))
        return calibrate(
            self.machine,
            self.values,
            self.run,
            self._named(outputs),
            measurements,
            bounds=bounds,
            sizes=sizes,
        )

    def _named(self, outputs: Sequence[str]) -> Any:
        """Outputs of the case that a machine belongs to; CaseError for names that it has not."""
        known = [each.name for each in self._outputs_of(self.machine(self.values))]
        for name in outputs:
            if name not in known:
                raise CaseError(f"no output is named {name!r}{did_you_mean(name, known)}")

        def of(system: System) -> list[Quantity]:
            return [each for each in self._outputs_of(system) if each.name in outputs]

        return of

    def _outputs_of(self, system: System) -> Sequence[Quantity]:
        return self._cases[system].quantities


@checked_arguments
def case_parameters(case: Path | str, paths: Sequence[str], *, allow_code: bool = False) -> CaseParameters:
    """Numbers of a case file by their paths, as parameters of its machine.

        own = sp.case_parameters("blade.toml", ["joint.shaft.law.speed", "body.blade.damping.ratio"])
        slopes = own.sensitivities(["deflection blade.TIP"]).derivatives

    Parameters
    ----------
    case : of its file
    paths : of numbers that change no body and no program: of loads, laws, joints, springs, elements, gravity;
        of rigid bodies; damping of bodies that are reduced here; as of the columns of a sweep
    allow_code : run the Python file of `control`, if the case names one

    Raises
    ------
    CaseError       a path that leads nowhere, to no number, or to one that makes another body
    SuppleError     whatever meshes, bodies and reductions find wrong
    """
    path = Path(case)
    raw = case_family(path).raw
    values = {name: number_of_run(path, name, raw)[1] for name in paths}
    table = CaseTable({name: [value] for name, value in values.items()})
    plan = make_plan(path, table, SweepOutput.model_validate({}), allow_code=allow_code)
    with tempfile.TemporaryDirectory(prefix="supple-parameters-") as folder:
        return CaseParameters(values, swept_group(Path(folder), plan, 0))

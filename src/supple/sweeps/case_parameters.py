"""Numbers of a case file as parameters, for derivatives of outputs and for fits to measurements."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
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
    """Some numbers of a case as parameters; bodies are reduced once for all values.

    values : values of the parameters in the case file, by path
    """

    values: Mapping[str, float]
    _group: SweptGroup
    _cases: WeakKeyDictionary[System, SweptCase] = field(default_factory=WeakKeyDictionary)

    @property
    def run(self) -> Run:
        """The run of the case."""
        return self._group.like.run

    def machine(self, values: Mapping[str, float]) -> System:
        """The machine at the start of its run with other values, by path; errors as for a case file."""
        places = self._group.plan.places
        found = self._group.with_values({places[path]: value for path, value in values.items()})
        self._cases[found.system] = found
        return found.system

    def sensitivities(
        self, outputs: Sequence[str], *, sizes: Mapping[str, float] = MappingProxyType({})
    ) -> Sensitivities:
        """Derivatives of outputs of the case with respect to its parameters, along the run.

        outputs : names of sensors, `joint NAME`, `position BODY.PLACE`, `deflection BODY.PLACE`, `energy`
        sizes, results, errors : as in `supple.sensitivity.sensitivities`
        """
        return sensitivities(self.machine, self.values, self.run, self._named(outputs), sizes=sizes)

    def calibrate(
        self,
        measurements: Sequence[Measurement],
        *,
        bounds: Mapping[str, tuple[float, float]] = MappingProxyType({}),
        sizes: Mapping[str, float] = MappingProxyType({}),
    ) -> Calibration:
        """Fit the parameters to measurements of outputs; the initial values are those of the case file.

        measurements : each `observable` is the name of an output, as in `sensitivities`
        bounds, sizes, results, errors : as in `supple.sensitivity.calibrate`
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

    def _named(self, outputs: Sequence[str]) -> Callable[[System], list[Quantity]]:
        """Function that returns the named outputs of a machine; CaseError for unknown names."""
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
    """Parameters of a machine: numbers of its case file, by their paths.

        own = sp.case_parameters("blade.toml", ["joint.shaft.law.speed", "body.blade.damping.ratio"])
        slopes = own.sensitivities(["deflection blade.TIP"]).derivatives

    Parameters
    ----------
    paths : paths of numbers that change no flexible body and no compiled program, as in a sweep: numbers of
        loads, laws, joints, springs, elements, gravity and rigid bodies; damping of bodies that are reduced
    allow_code : run the Python file of `control`, if the case names one

    Raises
    ------
    CaseError       a path that does not exist, is not a number, or changes a flexible body or the run
    SuppleError     errors of meshes, bodies and reductions
    """
    path = Path(case)
    raw = case_family(path).raw
    values = {name: number_of_run(path, name, raw)[1] for name in paths}
    table = CaseTable({name: [value] for name, value in values.items()})
    plan = make_plan(path, table, SweepOutput.model_validate({}), allow_code=allow_code)
    with tempfile.TemporaryDirectory(prefix="supple-parameters-") as folder:
        return CaseParameters(values, swept_group(Path(folder), plan, 0))

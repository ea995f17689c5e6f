"""The page of a sweep, and reports of the cases with the most extremes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.integrate import Progress
from supple.quantities import read_sensors, tracked_places
from supple.report import (
    ChannelOfCases,
    RainflowSpectrum,
    SweepPage,
    channels_that_fit,
    write_report,
    write_sweep_page,
)
from supple.report.page import PageSection
from supple.results import without_noise
from supple.results.run_tables import TextTable
from supple.simulation import simulate
from supple.storage.file_errors import file_errors
from supple.sweeps.certified_group import swept_case
from supple.sweeps.channel_statistics import STATISTICS
from supple.sweeps.over_seeds import conditions_of, over_conditions
from supple.sweeps.part_file import CaseStatus
from supple.sweeps.read_sweep import SweepColumns
from supple.sweeps.sweep_status import case_errors
from supple.units import labelled

__all__ = ["Extreme", "sweep_extremes", "write_sweep_report"]


_STATES = {CaseStatus.RAN: "ran", CaseStatus.FAILED: "failed", CaseStatus.KILLED: "killed its process"}
_NOT_RUN = "not run yet"
_MOST_FAILURES = 20
_REPORTS = "cases"
"""Folder of the reports of single cases; a sweep that starts again deletes it."""
_FIRST = ("maximum", "minimum")
"""Statistics in the first columns of the table of cases."""


class Extreme(NamedTuple):
    """The smallest or the largest value of a channel over all cases.

    statistic : "minimum" or "maximum"
    """

    channel: str
    statistic: str
    value: float
    case: int
    time: float


def sweep_extremes(folder: Path | str) -> list[Extreme]:
    """The smallest and the largest value of each channel over all cases of a sweep, with case and time.

    Channels that are constant up to rounding errors, such as forces normal to a planar mechanism, are left
    out. If several cases have the same value, the first is returned.

    Raises ResultFileError if the folder has no sweep.
    """
    return list(_extremes(SweepColumns(folder)))


def _extremes(columns: SweepColumns) -> Iterator[Extreme]:
    names = list(columns.channels["name"])
    values = {each: columns.statistic(each) for each in ("minimum", "maximum")}
    low = np.where(np.isnan(values["minimum"]), np.inf, values["minimum"]).argmin(axis=0)
    high = np.where(np.isnan(values["maximum"]), -np.inf, values["maximum"]).argmax(axis=0)
    moves = _moves(columns.channels["unit"], values["minimum"], values["maximum"])
    for statistic, cases in (("minimum", low), ("maximum", high)):
        instants = columns.statistic(f"time of {statistic}")
        for place in np.flatnonzero(moves).tolist():
            case = int(cases[place])
            value = float(values[statistic][case, place])
            yield Extreme(names[place], statistic, value, case, float(instants[case, place]))


def _moves(units: NDArray[Any], low: FloatArray, high: FloatArray) -> NDArray[np.bool_]:
    """Whether channels vary by more than rounding errors, (c,), from their extremes in all cases, (n, c)."""
    known = ~np.isnan(low)
    least, most = np.where(known, low, np.inf).min(axis=0), np.where(known, high, -np.inf).max(axis=0)
    moves = np.asarray(known.any(axis=0))
    for unit in set(units):
        own = moves & (units == unit)
        moves[own] = without_noise(most[own] - least[own], like=[*least[own], *most[own]]) > 0
    return moves


@checked_arguments
def write_sweep_report(
    folder: Path | str, n_reports: int = 0, *, allow_code: bool = False, progress: Progress | None = None
) -> Path:
    """Write `sweep.html` into the folder of a sweep: its cases with plots, extremes and spectra.

    If the sweep file has seeds, `conditions.html` shows the statistics over them.

    The cases with the most extremes are simulated again, and their reports are written to `cases/`, unless
    these reports exist. The page has links from the extremes to the reports in that folder. Returns the path
    of `sweep.html`.

    Parameters
    ----------
    n_reports : number of cases to simulate again
    allow_code : run the Python file of `control` in these simulations, if the case names one
    progress : called with the finished fraction of the cases to simulate again

    Raises
    ------
    ResultFileError     no sweep in the folder, input files that changed, a page that cannot be written
    """
    folder = Path(folder)
    columns = SweepColumns(folder)
    extremes = Counter(extreme.case for extreme in (_extremes(columns) if n_reports else ()))
    wanted = extremes.most_common(n_reports)
    for done, (case, _) in enumerate(wanted):
        if progress is not None:
            progress(done / len(wanted))
        target = folder / _REPORTS / f"{case:05}.html"
        if not target.exists():
            varied = "\n".join(f"{path} = {value}" for path, value in columns.table.row(case).items())
            with file_errors("make the folder", target.parent):
                target.parent.mkdir(exist_ok=True)
            _write_case_report(folder, case, target, varied, allow_code=allow_code)
    reports = {int(own.stem): f"{_REPORTS}/{own.name}" for own in sorted((folder / _REPORTS).glob("*.html"))}
    if columns.plan.output.seeds:
        write_sweep_page(folder / "conditions.html", _page_of_conditions(columns))
    else:
        with file_errors("remove", folder):
            (folder / "conditions.html").unlink(missing_ok=True)  # of an earlier sweep
    return write_sweep_page(folder / "sweep.html", _page(columns, reports))


def _write_case_report(folder: Path, number: int, target: Path, varied: str, *, allow_code: bool) -> None:
    """Simulate a case again and write its report."""
    swept = swept_case(folder, number, allow_code=allow_code)
    case, system = swept.case, swept.system
    solution = simulate(system, swept.run, check=False)
    write_report(
        target,
        system,
        solution,
        case.page_looks,
        title=f"{case.title or case.path.stem}, case {number}",
        tracked=tracked_places(system, solution, case.track, case.bases),
        readings=read_sensors(case.sensors, system, solution),
        elements=case.coloured_elements(system),
        bases=case.bases,
        inputs={case.path.name: case.text, "what varies": varied},
        units=case.units,
    )


def _page(columns: SweepColumns, reports: dict[int, str]) -> SweepPage:
    plan, units = columns.plan, columns.plan.family.case.units
    status, errors = columns.of_cases("status"), columns.of_cases("estimated_error")
    results = {
        "status": [_STATES.get(code, _NOT_RUN) for code in status.tolist()],
        "processor seconds": columns.of_cases("seconds"),
        **_columns_of_errors(columns, errors),
    }
    fatigue = plan.output.fatigue
    names = [*_FIRST, *(name for name in columns.statistics if name not in _FIRST)]
    n_channels = channels_that_fit(plan.n_cases, len(results) + len(plan.table.columns), len(names))
    kept = slice(0, n_channels)
    numbers = {name: columns.statistic(name, kept) for name in names}
    moves = _moves(columns.channels["unit"][kept], numbers["minimum"], numbers["maximum"])
    channels = [
        ChannelOfCases(name, unit, _of_channel(numbers, place), bool(moves[place]))
        for place, (name, unit) in enumerate(
            zip(columns.channels["name"][kept], columns.channels["unit"][kept], strict=True)
        )
    ]
    unit_of = {channel.name: channel.unit for channel in channels if channel.has_extremes}
    spectra = [
        RainflowSpectrum(name, unit_of[name], *own)
        for name, own in columns.spectra().items()
        if name in unit_of
    ]
    return SweepPage(
        title=f"{plan.family.case.title or plan.case_file.stem}: {plan.n_cases} cases",
        parameters=plan.table.columns,
        channels=channels,
        results=results,
        spectra=spectra,
        exponents=() if fatigue is None else fatigue.exponents,
        sections=[_summary(columns, status, errors, n_channels), *_lifetime(columns)],
        reports=reports,
        time=units.time,
    )


def _columns_of_errors(columns: SweepColumns, errors: FloatArray) -> dict[str, FloatArray | list[str]]:
    """Columns of estimated and allowed errors and their ratios; reasons for no estimate, if they differ."""
    allowed, reasons = columns.of_cases("allowed_error"), columns.of_cases("no_estimate")
    unit = columns.plan.units.length or ""
    found: dict[str, FloatArray | list[str]] = {}
    if not np.isnan(errors).all():
        found = {labelled("estimated error", unit): errors, "runs": columns.runs.astype(float)}
    if not np.isnan(ratios := _ratios(errors, allowed)).all():
        found |= {labelled("allowed error", unit): allowed, "estimated / allowed": ratios}
    # A reason that all cases have in common is shown above the table.
    return found | ({"why no estimate": reasons.tolist()} if len(set(reasons)) > 1 else {})


def _of_channel(numbers: dict[str, FloatArray], place: int) -> dict[str, FloatArray]:
    """Statistics of a channel, without statistics that no case has, such as those of fatigue."""
    known = {name: own[:, place] for name, own in numbers.items() if not np.isnan(own[:, place]).all()}
    return known or {name: numbers[name][:, place] for name in STATISTICS}


def _page_of_conditions(columns: SweepColumns) -> SweepPage:
    """The page with a row for each condition: means, deviations and extremes over its seeds."""
    plan = columns.plan
    numbers, conditions = conditions_of(plan.table, plan.output.seeds)
    names = [name for name in columns.statistics if not name.startswith("time of")]
    n_conditions = int(numbers.max()) + 1
    n_channels = channels_that_fit(n_conditions, len(conditions.columns) + 1, 3 * len(names))
    kept = slice(0, n_channels)
    by_channel: list[dict[str, FloatArray]] = [{} for _ in columns.channels["name"][kept]]
    for name in names:
        found = over_conditions(columns.statistic(name, kept), numbers)
        worst = found.minimum if name == "minimum" else found.maximum
        parts = {"mean": found.mean, "deviation": found.deviation, "extreme": worst}
        for place, own in enumerate(by_channel):
            if found.number[:, place].any():
                own |= {f"{name}, {part} over seeds": values[:, place] for part, values in parts.items()}
    ran = np.bincount(numbers, weights=columns.of_cases("status") == CaseStatus.RAN).astype(np.int64)
    sizes = np.bincount(numbers)
    least, most = sizes.min(), sizes.max()
    each = f"{least}" if least == most else f"{least} to {most}"
    lines = [
        f"{plan.n_cases} cases form {n_conditions} conditions of {each} cases. The cases of a condition "
        f"differ only in {', '.join(plan.output.seeds)}. Deviations are sample standard deviations (n - 1)."
    ]
    channels = zip(columns.channels["name"][kept], columns.channels["unit"][kept], by_channel, strict=True)
    return SweepPage(
        title=f"{plan.family.case.title or plan.case_file.stem}: statistics over seeds",
        parameters=conditions.columns,
        channels=[ChannelOfCases(*own, has_extremes=False) for own in channels],
        results={"cases with results": ran},
        sections=[PageSection("Conditions", lines)],
        row="condition",
        time=plan.family.case.units.time,
    )


def _lifetime(columns: SweepColumns) -> Iterator[PageSection]:
    """Section with loads and damage of the lifetime, if the sweep file requests them."""
    fatigue = columns.plan.output.fatigue
    if fatigue is None or fatigue.lifetime is None:
        return
    values, covered = columns.lifetime()
    asked = fatigue.lifetime
    lines = [
        f"Lifetime of {asked.duration:g} {columns.plan.units.time}; the wind speeds of the cases "
        f"({asked.speed}) cover {100 * covered:.3g} % of this lifetime. Damage-equivalent ranges are for "
        f"{asked.cycles:g} cycles; failure is at damage 1."
    ]
    rows = [
        (name, unit, *(f"{value:.4g}" if np.isfinite(value) else "" for value in own))
        for name, unit, own in zip(columns.channels["name"], columns.channels["unit"], values.T, strict=True)
        if (own > 0).any()
    ]
    if not rows:
        lines.append("Some cases have no results: loads and damage of the lifetime need all cases.")
    yield PageSection("Lifetime", lines, [TextTable("", ("channel", "unit", *fatigue.statistics), rows)])


def _ratios(errors: FloatArray, allowed: FloatArray) -> FloatArray:
    return np.divide(errors, allowed, out=np.full(errors.shape, np.nan), where=allowed > 0)


def _lines_of_errors(columns: SweepColumns, errors: FloatArray) -> Iterator[str]:
    allowed = columns.of_cases("allowed_error")
    found = case_errors(errors, allowed, columns.of_cases("no_estimate"))
    if found.n_estimated:
        plan, n_again = columns.plan, int((columns.runs > 1).sum())
        yield f"{found.line(plan.n_cases, n_again, plan.units.length)}."
    ratios = _ratios(errors, allowed)
    if len(known := ratios[~np.isnan(ratios)]):
        low, middle, high = np.quantile(known, (0.0, 0.5, 1.0))
        yield (
            f"Estimated over allowed error: {low:.3g} to {high:.3g}, median {middle:.3g}; largest in case "
            f"{int(np.nanargmax(ratios))}."
        )
    for reason, number in found.reasons.items():
        yield f"{number} cases without an estimate of their error: {reason}."


def _summary(
    columns: SweepColumns, status: NDArray[np.int8], errors: FloatArray, n_channels: int
) -> PageSection:
    counts = {word: int((status == code).sum()) for code, word in [*_STATES.items(), (-1, _NOT_RUN)]}
    said = ", ".join(f"{number} {word}" for word, number in counts.items() if number)
    lines = [f"{len(status)} cases of {columns.plan.case_file.name}: {said}."]
    lines += _lines_of_errors(columns, errors)
    if columns.plan.output.fatigue is not None:
        lines.append(f"Fatigue: {columns.plan.output.fatigue.conventions}.")
    left_out = len(columns.channels["name"]) - n_channels
    if left_out > 0:
        lines.append(f"{left_out} channels are not shown on this page; read_sweep reads all channels.")
    failed = np.flatnonzero(status > 0)[:_MOST_FAILURES]
    causes = columns.of_cases("cause") if len(failed) else ()
    rows = [(str(case), _STATES[CaseStatus(status[case])], causes[case]) for case in failed.tolist()]
    return PageSection("Sweep", lines, [TextTable("Cases without results", ("case", "what", "cause"), rows)])

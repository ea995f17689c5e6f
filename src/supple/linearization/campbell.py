"""Campbell diagram: frequency and damping of each mode of a machine, over its speed."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy  # its parts are imported when first used

from supple.arguments import checked_arguments
from supple.body import FullBody
from supple.errors import BasisWarning, ModelError, ValidityWarning
from supple.linearization.linear_machine import STANDING, Array, LinearMachine, likeness
from supple.linearization.linearize import linearize
from supple.linearization.machine_modes import MachineModes, damping_in_space, machine_modes
from supple.linearization.mode_names import mode_names
from supple.linearization.sparse_machine import SparseMachine
from supple.linearization.whirl import whirl
from supple.machine import Spin, System
from supple.progress import by_fraction, with_progress_bar
from supple.simulation.full_rest import known_fulls
from supple.summary import Summarized, Summary

__all__ = ["CampbellDiagram", "CriticalSpeed", "Onset", "campbell_diagram", "modal_assurance"]

GROWS = 1e-7
"""Ratio of a growth rate to the largest eigenvalue of the diagram, above which a mode is unstable."""


class CriticalSpeed(NamedTuple):
    """A speed at which unbalance excites a whirl.

    rate : rad per unit of time
    sense : of the whirl, as in `CampbellDiagram`
    """

    rate: float
    sense: int


class Onset(NamedTuple):
    """A speed, rad per unit of time, from which a mode is unstable, and the number of the mode, from 0."""

    rate: float
    mode: int


@dataclass(frozen=True, eq=False, repr=False)
class CampbellDiagram(Summarized):
    """Modes over speed, tracked by the modal assurance criterion (MAC).

    rates : (ns,) spin rates, rad per unit of time
    eigenvalues : complex (ns, nm)      one column per mode, in `axes`; NaN at a speed where no mode matches
    errors : (ns, nm) | None            relative error of each eigenvalue due to the reduction bases; infinite
                                        for a mode that the machine with full bodies does not have; NaN where
                                        no mode matches, or this machine has no equilibrium; None without
                                        full bodies
    likeness : (ns - 1, nm)             MAC of each mode between neighbouring speeds; low where modes veer;
                                        NaN where no mode matches
    axes : str                          axes to which the eigenvalues refer: "turning with the machine" or
                                        "standing in space"
    sense : (ns, nm)                    sense of whirl: 1 forward, -1 backward, 0 neither or unknown
    in_space : (ns, nm)                 frequency of the whirl in standing axes, rad per unit of time; NaN for
                                        a mode that does not move the rotor normal to its axis, or whose
                                        motion has several frequencies there
    names : (nm,)                       names of the modes by their motion at the fastest speed (`mode_names`)
    """

    rates: Array
    eigenvalues: np.ndarray
    likeness: Array
    errors: Array | None = None
    axes: str = STANDING
    sense: Array = field(default_factory=lambda: np.zeros((0, 0), dtype=int))
    in_space: Array = field(default_factory=lambda: np.zeros((0, 0)))
    names: tuple[str, ...] = ()

    def summary(self) -> Summary:
        """Critical speeds, onsets of instability, frequencies of each mode at the first and last speed."""
        hertz = self.frequencies / (2 * np.pi)
        names = self.names or [""] * hertz.shape[1]
        rows = [
            (f"mode {number} {name}".strip(), f"{first:.5g} to {last:.5g} cycles per unit of time")
            for number, (name, first, last) in enumerate(zip(names, hertz[0], hertz[-1], strict=True), 1)
        ]
        speeds = ", ".join(f"{each.rate:.5g}" for each in self.critical_speeds)
        rows.insert(0, ("critical speeds", speeds or "none"))
        if self.onsets:
            onsets = ", ".join(f"{each.rate:.5g} (mode {each.mode + 1})" for each in self.onsets)
            rows.insert(1, ("unstable from", onsets))
        first, last = self.rates[[0, -1]]
        return Summary(f"Campbell diagram from {first:g} to {last:g} rad per unit of time, {self.axes}", rows)

    @property
    def critical_speeds(self) -> tuple[CriticalSpeed, ...]:
        """Speeds at which the frequency of a whirl equals the spin rate, by linear interpolation, ascending.

        Backward whirl is included only for eigenvalues in standing axes, because unequal bearings couple both
        senses.
        """
        found = []
        pairs = zip(self.rates, self.in_space, self.sense, strict=True)
        for (rate, w, sense), (after, later, sense_later) in pairwise(pairs):
            known, known_later = (np.flatnonzero(np.isfinite(each)) for each in (w, later))
            unlike = sense[known][:, None] * sense_later[known_later] < 0
            apart = abs(w[known][:, None] - later[known_later]) + unlike * (
                1 + 2 * np.nanmax(later, initial=0)
            )
            for row, column in zip(*scipy.optimize.linear_sum_assignment(apart), strict=True):
                mode = int(known_later[column])
                own = int(sense_later[mode]) or int(sense[known[row]])  # at rest no sense is known
                ahead = w[known[row]] - abs(rate), later[mode] - abs(after)
                if ahead[0] * ahead[1] < 0 and (own >= 0 or self.axes == STANDING):
                    share = ahead[0] / (ahead[0] - ahead[1])
                    found.append(CriticalSpeed(float(rate + share * (after - rate)), own))
        found += [CriticalSpeed(rate, 1) for rate in self._divergences.values()]
        return tuple(sorted(found))

    @property
    def onsets(self) -> tuple[Onset, ...]:
        """Speeds from which modes are unstable: the first one, or by linear interpolation between speeds."""
        growth = self.eigenvalues.real
        least = GROWS * float(np.nanmax(abs(self.eigenvalues), initial=0.0))
        unstable = np.nan_to_num(growth) > least
        found = [Onset(float(self.rates[0]), int(mode)) for mode in np.flatnonzero(unstable[0])]
        for row, mode in np.argwhere(unstable[1:] & ~unstable[:-1]).tolist():
            if (row, mode) in self._divergences:
                found.append(Onset(self._divergences[row, mode], mode))
                continue
            before, after = growth[row : row + 2, mode]
            share = np.clip(before / (before - after), 0.0, 1.0) if np.isfinite(before) else 1.0
            rate = self.rates[row] + share * (self.rates[row + 1] - self.rates[row])
            found.append(Onset(float(rate), mode))
        return tuple(found)

    @cached_property
    def _divergences(self) -> dict[tuple[int, int], float]:
        """Limits of the speeds at which modes grow without oscillation in turning axes, by row and mode.

        A rotor of unequal stiffness diverges between its critical speeds. With the damping c, (s + c)^2 is
        smooth over the speed, and c^2 where s is zero.
        """
        limits: dict[tuple[int, int], float] = {}
        if self.axes == STANDING:
            return limits
        least = GROWS * float(np.nanmax(abs(self.eigenvalues), initial=0.0))
        diverges = (self.eigenvalues.imag == 0) & (self.eigenvalues.real > least)
        for row, mode in np.argwhere(diverges[1:] != diverges[:-1]).tolist():
            s, grows_first = self.eigenvalues[:, mode], bool(diverges[row, mode])
            # Both speeds, and a third one at which the mode oscillates.
            third = row + 2 if grows_first else row - 1
            rows = [row, row + 1, *[third] * (0 <= third < len(s))]
            damping = -s[row + 1 if grows_first else row].real
            squares = ((s[rows] + damping) ** 2).real - damping**2
            if np.isfinite(squares).all():
                start = self.rates[row]
                roots = np.roots(np.polyfit(self.rates[rows] - start, squares, len(rows) - 1))
                inside = [
                    float(each.real)
                    for each in roots
                    if each.imag == 0 and 0 <= each.real / (self.rates[row + 1] - start) <= 1
                ]
                if inside:
                    limits[row, mode] = float(start + inside[0])
        return limits

    @property
    def frequencies(self) -> Array:
        """Damped angular frequencies, rad per unit of time, (ns, nm)."""
        return self.eigenvalues.imag

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios `-Re(s) / |s|` of the eigenvalues s in `axes`, (ns, nm); NaN as these."""
        return damping_in_space(self.eigenvalues, self.frequencies)

    @property
    def observed_damping_ratios(self) -> Array:
        """Damping ratios (ns, nm) of whirls in space, and of all other motions in `axes`."""
        if not self.in_space.size:
            return self.damping_ratios
        in_space = damping_in_space(self.eigenvalues, self.in_space)
        return np.where(np.isnan(in_space), self.damping_ratios, in_space)


def modal_assurance(first: MachineModes, second: MachineModes) -> Array:
    """MAC (n1, n2) of the shapes a and b of two sets of modes: `|a^H b|^2 / (|a|^2 |b|^2)`, in the mass norm.

    Zero for modes of controllers alone. Raises ModelError if the machines have different numbers of
    coordinates.
    """
    if len(first.shapes) != len(second.shapes):
        raise ModelError(
            "modal assurance needs modes of machines with equal numbers of coordinates, not "
            f"{len(first.shapes)} and {len(second.shapes)}"
        )
    # Motions of frames and coordinates have different units: the mass of the first machine weights them.
    machine = first.machine
    return likeness(first.independent, machine.coordinates_of(second.shapes), machine.mass)


@checked_arguments
@with_progress_bar("finding modes by speed", by_fraction)
def campbell_diagram(
    system: System,
    spins: Sequence[Spin],
    *,
    n_modes: int = 6,
    time: float = 0.0,
    fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> CampbellDiagram:
    """Modes of a machine over its speed, each about the equilibrium at this speed, tracked by their shapes.

    Parameters
    ----------
    spins : Spin    one for each speed, in the order of tracking, with small steps; the first rate may be zero
    n_modes : number of modes to track; they are the slowest modes at the first speed
    time : time at which loads and laws are evaluated
    fulls : full bodies, as for `equilibrium`; at each speed, equilibrium and modes of the machine with full
        bodies are computed, for the errors of the bases

    Raises
    ------
    ModelError          no speed; the errors of `linearize`
    ConvergenceError    no equilibrium at a speed
    Warns BasisWarning if a basis error of modes or equilibrium is 1 % or more, with the speed of the largest
    error; and ValidityWarning with the fastest speed at which a body exceeds a limit of its kinematics.
    """
    if not spins:
        raise ModelError("a Campbell diagram needs at least one speed")
    tracked: list[_AtSpeed] = []
    beyond: list[list[str]] = []
    words: list[list[str]] = []
    before: MachineModes | None = None
    axes, names = STANDING, np.array([])
    fastest = max(range(len(spins)), key=lambda each: (abs(spins[each].rate), each))
    for number, spin in enumerate(spins):
        with _held(ValidityWarning) as limits, _held(BasisWarning) as errors:
            linear = linearize(system, spin=spin, time=time, fulls=fulls)
            # With full bodies there are very many modes: matches are sought among some more than n_modes.
            modes = machine_modes(linear, 2 * n_modes + 6 if isinstance(linear, SparseMachine) else None)
            if before is None:
                rows = chosen = np.arange(min(n_modes, len(modes.eigenvalues)))
                before, alike = _some(modes, chosen), np.ones(len(chosen))
            else:
                table, apart = _likeness(before, modes)
                # Among similar shapes, the one with the nearest frequency is chosen.
                rows, chosen = scipy.optimize.linear_sum_assignment(apart - table + _unlikely(before, modes))
                alike = table[rows, chosen]
            found, own = _some(modes, chosen), whirl(modes)
            of_bases = _errors(linear, chosen)
        beyond.append(limits)
        words.append(errors)
        in_space = own.frequencies[chosen]
        values = (found.eigenvalues, of_bases, own.sense[chosen].astype(float), in_space, alike)
        tracked.append(_AtSpeed(*(_placed(len(before.eigenvalues), rows, each) for each in values)))
        # A mode without a match (its pair may have become real) keeps its last shape, for matching later.
        shapes = modes.machine.coordinates_of(before.shapes)
        shapes[:, rows] = found.independent
        eigenvalues = before.eigenvalues.copy()
        eigenvalues[rows] = found.eigenvalues
        axes = modes.machine.axes if spin.rate else axes
        if number == fastest:
            names = np.full(len(shapes.T), "", dtype=object)
            names[rows] = mode_names(found)
        before = replace(modes, eigenvalues=eigenvalues, independent=shapes)
        progress((number + 1) / len(spins))
    rates = np.array([spin.rate for spin in spins])
    followed = _AtSpeed(*map(np.array, zip(*tracked, strict=True)))
    largest = np.nan_to_num(followed.errors, nan=0.0, posinf=1.0).max(axis=1, initial=0.0)
    _warn_of_worst(BasisWarning, words, largest, rates)
    _warn_of_worst(ValidityWarning, beyond, abs(rates))
    return CampbellDiagram(
        rates,
        followed.eigenvalues,
        followed.likeness[1:],
        followed.errors if known_fulls(system, fulls) else None,
        axes,
        np.nan_to_num(followed.sense).astype(int),
        followed.in_space,
        tuple(names),
    )


class _AtSpeed(NamedTuple):
    """The followed modes (nm,) at a speed, NaN without a match; `likeness` to those at the speed before."""

    eigenvalues: np.ndarray
    errors: Array
    sense: Array
    in_space: Array
    likeness: Array


def _likeness(before: MachineModes, modes: MachineModes) -> tuple[Array, Array]:
    """MAC of the modes at two speeds, and the relative distance of their eigenvalues, (n1, n2) each.

    In axes that turn, the frequency w - W of a forward whirl passes zero at its critical speed. Beyond, the
    mode above the real axis is the conjugate of the followed one: of both pairs the nearer one counts.
    """
    old, new = before.eigenvalues[:, None], modes.eigenvalues
    table, size = modal_assurance(before, modes), abs(old) + abs(new) + 1e-300
    turning = [each.machine for each in (before, modes) if each.machine.axes != STANDING]
    if not turning:
        return table, abs(old - new) / size
    # A frequency w - W near zero is not small beside the change of W.
    size = size + 2 * max(abs(each.spin.rate) for each in turning if each.spin is not None)
    apart, through = abs(old - new) / size, abs(old - np.conj(new)) / size
    passed = modal_assurance(before, replace(modes, independent=modes.independent.conj()))
    nearer = through - passed < apart - table
    return np.where(nearer, passed, table), np.where(nearer, through, apart)


def _unlikely(before: MachineModes, modes: MachineModes) -> Array:
    """1 for real decaying eigenvalues (n1, n2) that oscillated before, if a real one grows; 0 for all others.

    Where a pair becomes two real eigenvalues, the growing one is followed.
    """
    real = modes.eigenvalues.imag == 0
    grows = real & modes.unstable
    decays = real & (modes.eigenvalues.real < 0) & bool(grows.any())
    return (before.eigenvalues.imag[:, None] > 0) & decays


def _some(modes: MachineModes, chosen: np.ndarray) -> MachineModes:
    """The modes with the numbers `chosen`."""
    return replace(
        modes,
        eigenvalues=modes.eigenvalues[chosen],
        independent=modes.independent[:, chosen],
        states=modes.states[:, chosen],
        error=None,
    )


def _errors(linear: LinearMachine | SparseMachine, chosen: np.ndarray) -> Array:
    """Basis errors of the modes with the numbers `chosen`; NaN without full bodies."""
    if not isinstance(linear, LinearMachine) or linear.full is None:
        return np.full(len(chosen), np.nan)
    error = machine_modes(linear, int(chosen.max()) + 1).error
    assert error is not None  # for a known full machine and a number of modes
    return error.relative[chosen]


@contextmanager
def _held(category: type[Warning]) -> Iterator[list[str]]:
    """Collect the messages of warnings of a category within the block; other warnings pass."""
    words: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", category)
        yield words
    for each in caught:
        if issubclass(each.category, category):
            words.append(str(each.message))
        else:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)


def _warn_of_worst(
    category: type[Warning], messages: Sequence[Sequence[str]], sizes: Array, rates: Array | None = None
) -> None:
    """Warn with the messages of the speed of the largest size among the speeds with messages."""
    warned = [number for number, words in enumerate(messages) if words]
    if not warned:
        return
    worst = max(warned, key=lambda number: sizes[number])
    most = "" if rates is None else f", most at {rates[worst]:.4g} rad per unit of time"
    for words in messages[worst]:
        warnings.warn(f"at {len(warned)} of {len(messages)} speeds{most}: {words}", category, stacklevel=4)


def _placed(size: int, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values in their rows, NaN elsewhere."""
    every = np.full(size, np.nan, dtype=values.dtype)
    every[rows] = values
    return every

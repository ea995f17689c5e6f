"""Error-controlled reduction of the bodies of [Han2020]: how many modes, how good the estimates, how sure.

The paper's cylinder (section 5.1) and connecting rod (5.2) on meshes of our own, with four- and ten-node
tetrahedra. For each tolerance: the fixed-interface modes that every estimator asks for and that the exact
errors need, the estimates over the exact errors, the proof, and what it costs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from supple.algebra import lowest_modes
from supple.benchmark.basis_sizes import BasisSize, basis_sizes
from supple.benchmark.free_beam import RoundBeam
from supple.benchmark.slider_crank import ALUMINIUM, ROD
from supple.body import AveragingInterface, FlexibleBody, RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, RodCells, connecting_rod, cylinder
from supple.reduction import (
    Bisection,
    CraigBamptonFamily,
    ErrorControlled,
    ErrorEstimator,
    FirstOrderEstimate,
    Han2020Bound,
    KnownEigenvalues,
    OneByOne,
    SearchStep,
    SharperBound,
    TwoTermEstimate,
    count_eigenvalues,
    error_controlled_modes,
)

__all__ = [
    "BeamFrequency",
    "BodyCase",
    "BodyResult",
    "EigenvalueErrors",
    "ToleranceResult",
    "beam_frequencies",
    "run_eigenvalue_errors",
]

Array = np.ndarray
Progress = Callable[[float], None]

ESTIMATORS: Mapping[str, ErrorEstimator] = {
    "lower": FirstOrderEstimate(),
    "paper": Han2020Bound(),
    "sharp": SharperBound(),
    "two_term": TwoTermEstimate(),
}
LENGTH, RADIUS = 0.3, 0.015
STEEL_LIKE = Isotropic(youngs_modulus=100e9, poissons_ratio=0.285, density=7850.0)
BORES = ("big_bore", "small_bore")
ELEMENTS = {CellType.TETRA4: "tet4", CellType.TETRA10: "tet10"}


@dataclass(frozen=True)
class BodyCase:
    """A body to reduce.

    name, element : as in the report        n_modes : elastic eigenvalues controlled, N_m
    published : {tolerance: modes} of the paper, on its own mesh
    """

    name: str
    element: str
    n_modes: int
    published: Mapping[float, int]
    build: Callable[[], FlexibleBody]


@dataclass(frozen=True)
class EigenvalueErrors:
    """Size of the benchmark.

    tolerances : relative eigenvalue errors
    cylinders : (element, layers of 126 tetrahedra along the cylinder)
    rods : (element, cells of the rod)
    beams : (element, (n_core, n_ring, n_length)), cylinders compared with beam theory
    candidates : modes of either kind among which the reduction bases are compared
    """

    tolerances: tuple[float, ...] = (0.1, 0.01, 0.001)
    cylinders: tuple[tuple[CellType, int], ...] = ((CellType.TETRA10, 28), (CellType.TETRA4, 28))
    rods: tuple[tuple[CellType, RodCells], ...] = (
        (CellType.TETRA10, RodCells()),
        (CellType.TETRA4, RodCells()),
    )
    beams: tuple[tuple[CellType, tuple[int, int, int]], ...] = (
        (CellType.TETRA10, (3, 1, 28)),
        (CellType.TETRA4, (3, 1, 28)),
        (CellType.TETRA4, (4, 2, 48)),
        (CellType.TETRA4, (6, 3, 70)),
    )
    candidates: int = 300

    @classmethod
    def quick(cls) -> EigenvalueErrors:
        """Four-node tetrahedra as published, ten-node ones on coarse meshes: under 40 s."""
        coarse = RodCells(around=12, ring=1, shank=10, width=3, thickness=2)
        return cls(
            cylinders=((CellType.TETRA10, 8), (CellType.TETRA4, 28)),
            rods=((CellType.TETRA10, coarse), (CellType.TETRA4, RodCells())),
            beams=((CellType.TETRA10, (3, 1, 20)), (CellType.TETRA4, (3, 1, 28))),
            candidates=160,
        )

    def cases(self) -> tuple[BodyCase, ...]:
        """All bodies."""
        return (
            *(cylinder_case(element, n_length) for element, n_length in self.cylinders),
            *(rod_case(element, cells) for element, cells in self.rods),
        )


def cylinder_case(element: CellType, n_length: int) -> BodyCase:
    """The flexible link of the quadruple pendulum; its right end is the interface."""

    def build() -> FlexibleBody:
        mesh = cylinder(RADIUS, LENGTH, 3, 1, n_length, element)
        return flexible_body("cylinder", solid_model(mesh, STEEL_LIKE), [RigidInterface("end", "tip")])

    return BodyCase("cylinder", ELEMENTS[element], 30, {0.1: 35, 0.01: 58, 0.001: 446}, build)


def rod_case(element: CellType, cells: RodCells) -> BodyCase:
    """The rod of the slider-crank; its bores are the interfaces."""

    def build() -> FlexibleBody:
        mesh = connecting_rod(ROD, cells, element)
        bores = [RigidInterface(bore, bore) for bore in BORES]
        return flexible_body("rod", solid_model(mesh, ALUMINIUM), bores)

    return BodyCase("rod", ELEMENTS[element], 10, {0.1: 8, 0.01: 25, 0.001: 105}, build)


class Seconds(NamedTuple):
    """What a step took on the clock and of the processor; other work on the machine makes them differ."""

    wall: float
    cpu: float


@dataclass(frozen=True, eq=False)
class ToleranceResult:
    """One body at one tolerance.

    modes : kept, by the sharper bound and the proof
    estimated_modes : {estimator: modes} that each asks for, unproven; "exact" what exact errors need
    exact, proven : (N,)            exact errors, and the bounds proven for them
    estimates : {estimator: (N,)}   at `modes`
    counts : inertia counts made, each proving its eigenvalues by itself; counted: whether all did
    seconds, seconds_one_by_one : the whole reduction, proof included, with either search
    seconds_plain : one reduction with as many modes, without search or proof
    same_answer : whether both searches keep as many modes
    steps, n_one_by_one : the steps of one, the number of steps of the other
    """

    tolerance: float
    modes: int
    estimated_modes: Mapping[str, int]
    exact: Array
    proven: Array
    estimates: Mapping[str, Array]
    counts: int
    counted: bool
    seconds: Seconds
    seconds_one_by_one: Seconds
    seconds_plain: Seconds
    same_answer: bool
    steps: tuple[SearchStep, ...]
    n_one_by_one: int

    def effectivity(self, estimator: str) -> Array:
        """Estimated over exact error (N,)."""
        return self.estimates[estimator] / self.exact


@dataclass(frozen=True, eq=False)
class BodyResult:
    """One body at all tolerances.

    n, nodes, cells : freedoms, nodes, tetrahedra
    exact : (N,)            eigenvalues of the full body, rad^2/s^2
    bases : modes that each reduction basis needs for the same exact errors
    """

    case: BodyCase
    n: int
    nodes: int
    cells: int
    exact: Array
    results: tuple[ToleranceResult, ...]
    bases: tuple[BasisSize, ...]


def run_eigenvalue_errors(
    problem: EigenvalueErrors, progress: Callable[[str], Progress]
) -> Iterator[BodyResult]:
    """The results of each body, as they come."""
    for case in problem.cases():
        yield _run_case(case, problem, progress(f"{case.name} {case.element}"))


def _run_case(case: BodyCase, problem: EigenvalueErrors, advance: Progress) -> BodyResult:
    body = case.build()
    elastic = (body.mass @ body.rigid_modes).T
    exact = lowest_modes(body.stiffness, body.mass, case.n_modes, constraint=elastic).values
    family = CraigBamptonFamily(body)
    results = []
    for done, tolerance in enumerate(problem.tolerances):
        results.append(_at_tolerance(body, family, exact, tolerance))
        advance((done + 1) / (len(problem.tolerances) + 1))
    sizes = basis_sizes(
        body, problem.tolerances, case.n_modes, candidates=problem.candidates, fixed_modes=family.modes
    )
    advance(1.0)
    assert body.model is not None
    cells = body.model.mesh.cells[body.model.mesh.only_cell_type()]
    return BodyResult(case, body.n, len(body.nodes), len(cells), exact, tuple(results), sizes)


def _at_tolerance(
    body: FlexibleBody, family: CraigBamptonFamily, exact: Array, tolerance: float
) -> ToleranceResult:
    n_modes, known = exact.size, KnownEigenvalues(exact)
    times = [_now()]
    reduced = error_controlled_modes(body, ErrorControlled(tolerance, n_modes)).certificate
    n_kept = reduced.n_fixed_interface_modes
    times.append(_now())
    published = error_controlled_modes(body, ErrorControlled(tolerance, n_modes, search=OneByOne()))
    times.append(_now())
    one_size = CraigBamptonFamily(body)
    one_size.vectors(one_size.vibrations(n_kept, n_modes))
    times.append(_now())
    searched, searched_one_by_one, plain = (Seconds(*row) for row in np.diff(times, axis=0).tolist())
    asked = {name: _asked(family, tolerance, n_modes, one) for name, one in ESTIMATORS.items()}
    counts = count_eigenvalues(body, reduced.values, tolerance)
    return ToleranceResult(
        tolerance=tolerance,
        modes=n_kept,
        estimated_modes={**asked, "exact": _asked(family, tolerance, n_modes, known)},
        exact=family.errors(n_kept, n_modes, known),
        proven=reduced.errors,
        estimates={name: family.errors(n_kept, n_modes, one) for name, one in ESTIMATORS.items()},
        counts=len(counts),
        counted=all(group.proven for group in counts),
        seconds=searched,
        seconds_one_by_one=searched_one_by_one,
        seconds_plain=plain,
        same_answer=published.certificate.n_fixed_interface_modes == n_kept,
        steps=reduced.steps,
        n_one_by_one=len(published.certificate.steps),
    )


def _now() -> tuple[float, float]:
    return perf_counter(), process_time()


def _asked(family: CraigBamptonFamily, tolerance: float, n_modes: int, estimator: ErrorEstimator) -> int:
    def trial(n_kept: int) -> SearchStep:
        errors = family.errors(n_kept, n_modes, estimator)
        return SearchStep(n_kept, errors, tolerance, type(estimator).__name__, 0.0)

    return Bisection().run(trial, 5, family.n_available)[-1].n_modes


@dataclass(frozen=True)
class BeamFrequency:
    """A frequency of the free cylinder by solid elements and by beam theory, Hz."""

    element: str
    cells: int
    motion: str
    number: int
    computed: float
    theory: float

    @property
    def stiffness_error(self) -> float:
        """How much too stiff, as a share of the frequency."""
        return self.computed / self.theory - 1.0


def beam_frequencies(
    problem: EigenvalueErrors, n_bending: int = 3, n_torsion: int = 2
) -> list[BeamFrequency]:
    """The lowest bending and torsional frequencies of the free cylinder on several meshes."""
    beam = RoundBeam(LENGTH, RADIUS, STEEL_LIKE)
    rows = []
    for element, counts in problem.beams:
        mesh = cylinder(RADIUS, LENGTH, *counts, element)
        # An averaging interface, which holds nothing: a rigid end would stiffen the section there.
        body = flexible_body("cylinder", solid_model(mesh, STEEL_LIKE), [AveragingInterface("end", "tip")])
        n_modes = 2 * n_bending + 2 * n_torsion + 4
        modes = lowest_modes(body.stiffness, body.mass, n_modes, constraint=(body.mass @ body.rigid_modes).T)
        frequencies = np.sqrt(modes.values) / (2 * np.pi)
        kinds = _kinds(body, body.expansion @ modes.vectors)
        # A pair of bending modes, one for each direction, counts once.
        bending = frequencies[kinds == "bending"][::2][:n_bending]
        torsion = frequencies[kinds == "torsion"][:n_torsion]
        cells = len(mesh.cells[element])
        for motion, found, theory in (
            ("bending", bending, beam.bending(n_bending)),
            ("torsion", torsion, beam.torsion(n_torsion)),
        ):
            rows += [
                BeamFrequency(ELEMENTS[element], cells, motion, number, float(pair[0]), float(pair[1]))
                for number, pair in enumerate(zip(found, theory, strict=False), start=1)
            ]
    return rows


def _kinds(body: FlexibleBody, shapes: Array) -> Array:
    """Torsion, stretching or bending, by the share of the motion that runs around or along the axis."""
    u = shapes.reshape(len(body.nodes), 3, -1)
    y, z = body.nodes[:, 1], body.nodes[:, 2]
    r = np.hypot(y, z)
    reciprocal = np.divide(1.0, r, out=np.zeros_like(r), where=r > 0)
    around = (reciprocal * y)[:, None] * u[:, 2] - (reciprocal * z)[:, None] * u[:, 1]
    whole = np.sum(u**2, axis=(0, 1))
    return np.where(
        np.sum(around**2, axis=0) > 0.9 * whole,
        "torsion",
        np.where(np.sum(u[:, 0] ** 2, axis=0) > 0.8 * whole, "stretching", "bending"),
    )

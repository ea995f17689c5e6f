"""How many modes each reduction basis needs for the same exact eigenvalue errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg, sparse

from supple.algebra import GrowingModes, RitzModes, lowest_modes
from supple.body import FlexibleBody, MeanAxisFrame
from supple.errors import ModelError
from supple.reduction import (
    ComponentModel,
    DualCraigBampton,
    FixedInterfaceComponent,
    FreeInterfaceComponent,
    MacNealComponent,
    ReducedMatrices,
    RitzComponent,
    craig_bampton_component,
    enhanced_component,
    fixed_interface_component,
    free_interface_component,
    residual_component,
    rubin_component,
)
from supple.reduction.bases.interface_columns import motion_rows, require_interfaces
from supple_benchmarks.table import Row


@dataclass(frozen=True)
class BasisSize:
    """The smallest basis of a family with an error within a tolerance.

    basis : name of the family
    interfaces : "free", "held" or "loaded": which eigenvalues are compared, see `basis_sizes`
    tolerance : largest relative eigenvalue error allowed
    modes : number of modes; None if the error exceeds the tolerance even with all candidates
    coordinates : of the free body, with rigid motions and static columns; None if modes is None
    largest_error : of the eigenvalues compared, at that size (with all candidates if modes is None)
    """

    basis: str
    interfaces: str
    tolerance: float
    modes: int | None
    coordinates: int | None
    largest_error: float

    def as_row(self) -> Row:
        """A row of a report, where size is the number of modes."""
        return {
            "basis": self.basis,
            "interfaces": self.interfaces,
            "e": self.tolerance,
            "size": self.modes,
            "coordinates": self.coordinates,
            "max_error": self.largest_error,
        }


def basis_sizes(
    body: FlexibleBody,
    tolerances: Sequence[float],
    n_modes: int,
    *,
    candidates: int = 300,
    fixed_modes: RitzModes | None = None,
    free_modes: RitzModes | None = None,
) -> tuple[BasisSize, ...]:
    """Modes that each basis needs for |lambda_reduced / lambda_exact - 1| <= e in the n_modes lowest modes.

    Three sets of exact eigenvalues are compared, because each family is exact by construction in one of them:

    free     elastic modes of the free body: contained in free-interface bases
    held     modes with all interfaces clamped: contained in fixed-interface bases
    loaded   modes with a rigid body at each interface, which has the inertia of the body itself at that
             interface (the block of Psi^T M Psi of the interface): between free and held, as in a mechanism,
             and contained in neither family

    Each family needs one eigen-solution with all candidates. Every size is then a leading block of small
    matrices, with a rank-one update of the residual per omitted mode. The size is found by bisection, since
    errors decrease with each mode. Errors of the enhanced Craig-Bampton basis need not decrease: the size
    found meets the tolerance and the next smaller size does not, but a still smaller one may.

    candidates : number of modes computed per family, at most as many as the body has
    fixed_modes, free_modes : the lowest fixed-interface and free modes, if already known
    Returns BasisSize for each of free, held, loaded, each basis and each tolerance, in that order.
    Raises ModelError when the body has no interface, or a family has fewer than n_modes modes.
    """
    require_interfaces(body, "a comparison of bases")
    b = 6 * len(body.interfaces)
    # The omitted modes must leave a residual for every interface degree of freedom.
    n_candidates = min(candidates, body.n - 2 * b)
    fixed = fixed_modes or _lowest(body, motion_rows(body.interfaces), n_candidates)
    free = free_modes or _lowest(body, MeanAxisFrame().constraint(body), n_candidates)
    n_candidates = min(n_candidates, fixed.values.size, free.values.size)
    if not 1 <= n_modes <= n_candidates:
        raise ModelError(
            f"body '{body.name}': {n_modes} modes to compare among {n_candidates} candidates; "
            "give more candidates, or a finer mesh"
        )
    component = fixed_interface_component(body, fixed).leading(n_candidates)
    free_component = free_interface_component(body, free).leading(n_candidates)
    families = _fixed_families(component) + _free_families(free_component)
    return tuple(
        size
        for comparison in _comparisons(body, component, fixed, free, n_modes)
        for family in families
        for size in _smallest(family, comparison, tolerances)
    )


def _lowest(body: FlexibleBody, constraint: np.ndarray, n_modes: int) -> RitzModes:
    return GrowingModes(body.constrained(constraint), body.mass).at_least(n_modes)


class _Family(NamedTuple):
    """A kind of basis: its model for each number of modes, and the number of added coordinates."""

    name: str
    model: Callable[[int], ComponentModel]
    n_static: int
    n_candidates: int


class _Comparison(NamedTuple):
    """Exact eigenvalues, without the n_rigid zero ones, and the reduced matrices that approximate them."""

    name: str
    exact: np.ndarray
    n_rigid: int
    matrices: Callable[[ComponentModel], ReducedMatrices]

    def largest_error(self, model: ComponentModel) -> float:
        """Largest relative error of the eigenvalues; infinite when the model has too few."""
        spectrum = self.matrices(model).spectrum[self.n_rigid :]
        if spectrum.size < self.exact.size:
            return np.inf
        return float(np.max(np.abs(spectrum[: self.exact.size] / self.exact - 1.0)))


def _fixed_families(component: FixedInterfaceComponent) -> list[_Family]:
    b, available = len(component.interface_mass), component.n_modes

    def of(build: Callable[[FixedInterfaceComponent], RitzComponent]) -> Callable[[int], RitzComponent]:
        return lambda n: build(component.leading(n))

    return [
        _Family("Craig-Bampton", of(craig_bampton_component), b, available),
        _Family("Craig-Bampton with residual modes", of(residual_component), 2 * b, available),
        _Family("enhanced Craig-Bampton", of(enhanced_component), b, available),
    ]


def _free_families(component: FreeInterfaceComponent) -> list[_Family]:
    b, available = len(component.residual_mass), component.n_modes

    def of(build: Callable[[FreeInterfaceComponent], ComponentModel]) -> Callable[[int], ComponentModel]:
        return lambda n: build(component.leading(n))

    return [
        _Family("Rubin", of(rubin_component), 6 + b, available),
        # Herting's basis has other columns with the same span, and as many coordinates: see Herting.
        _Family("Herting", of(rubin_component), 6 + b, available),
        _Family("MacNeal", of(MacNealComponent), 6 + b, available),
        _Family("dual Craig-Bampton", of(DualCraigBampton), 6 + b, available),
    ]


def _comparisons(
    body: FlexibleBody, component: FixedInterfaceComponent, fixed: RitzModes, free: RitzModes, n_modes: int
) -> list[_Comparison]:
    blocks = [component.interface_mass[i : i + 6, i : i + 6] for i in range(0, 6 * len(body.interfaces), 6)]
    added = linalg.block_diag(*blocks)
    B = sparse.csc_array(motion_rows(body.interfaces))
    mass = sparse.csc_array(body.mass + B.T @ sparse.csc_array(added) @ B)
    loaded = lowest_modes(body.stiffness, mass, n_modes, constraint=(mass @ body.rigid_modes).T)
    return [
        _Comparison("free", free.values[:n_modes], 6, lambda model: model.interfaces_free()),
        _Comparison("held", fixed.values[:n_modes], 0, lambda model: model.interfaces_fixed()),
        _Comparison("loaded", loaded.values, 6, lambda model: model.interfaces_loaded(added)),
    ]


def _smallest(family: _Family, comparison: _Comparison, tolerances: Sequence[float]) -> list[BasisSize]:
    """Bisection for each tolerance; errors already known are not computed again."""
    errors: dict[int, float] = {}

    def error(n: int) -> float:
        if n not in errors:
            errors[n] = comparison.largest_error(family.model(n))
        return errors[n]

    sizes = []
    for tolerance in tolerances:
        low, high = -1, family.n_candidates
        if error(high) > tolerance:
            sizes.append(BasisSize(family.name, comparison.name, tolerance, None, None, error(high)))
            continue
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if error(middle) <= tolerance else (middle, high)
        coordinates = family.n_static + high
        sizes.append(BasisSize(family.name, comparison.name, tolerance, high, coordinates, error(high)))
    return sizes

"""Basis errors of reduced bodies at an equilibrium, by comparison with the equilibrium with all coordinates.

At the equilibrium of a reduced machine, expanded to all coordinates, the full equations leave a residual r,

    [ K_T + M / k   G^T ] [ delta  ]       [ r ]
    [ G              0  ] [ lambda ]  =  - [ g ],       k >> 1 / omega^2 of all vibrations,

where K_T is the tangent stiffness, M the mass matrix, g the gaps of joints, and G the constraints of joints
and frames. The matrix is factored once. Repeated sweeps use this factor, each from the state corrected by the
previous sweep. The sum of the corrections is the error. The ratio of the second sweep to the first shows
whether first order suffices. If a sweep exceeds a third of the previous one, the equilibrium of the full
machine is searched from the expanded equilibrium instead; if that fails, from the undeformed shape.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from supple.algebra import read_only
from supple.body import FullBody, MeanAxisFrame, frame_projector
from supple.equations.machine_model import Model
from supple.equations.static_search import StaticSearch, StaticState, moved_state, search_equilibrium
from supple.errors import AccuracyError, ConvergenceError, ModelError
from supple.machine import System
from supple.methods.floating.full.statics import FullStatics, full_statics
from supple.methods.intrinsic.line_in_frame import lines_in_frames
from supple.quantities.quantity_of_interest import ROUND_OFF, largest_displacement
from supple.reduction import Condensation, ReducedBody, ReductionBasis
from supple.simulation.equations_of import with_held_servos
from supple.simulation.resting_state import RestingState, placed_at_rest
from supple.simulation.stored_basis import stored_bases

SLOWNESS = 1e3
"""Lowest angular frequency times `sqrt(k)`: M / k is then negligible compared with K_T."""
CONTRACTS = 1 / 3
"""Largest ratio of a sweep to the previous sweep; above it the sweeps are replaced by a search."""
CONVERGED = 1e-4
"""Size of a sweep, relative to the first sweep, below which no further sweep is made."""
NOTHING = 1e-8
"""Size of a sweep, relative to the size of the machine, below which no further sweep is made."""
MOST_SWEEPS = 12
NEAR_BY = 20
"""Largest number of iterations of the search from the reduced equilibrium if the sweeps do not contract."""


@dataclass(frozen=True, eq=False)
class EquilibriumError:
    """Error of the basis of a reduced body at an equilibrium.

    displacement : (N, 3)   of the nodes, in space: positions with all coordinates minus positions of the
                reduced body; without rigid motion where the joints leave it free
    deformation : (n,)      all coordinates of the body in its frame, minus those of its columns without the
                condensed motion: the column that its basis lacks
    size : float            largest displacement of a node, relative to the first interface; zero if it is
                rounding only
    strain : float          square root of the ratio of two strain energies: missing to whole deformation
    second : float          ratio of the second sweep to the first: above a third, first order is insufficient
    known : bool            False if no equilibrium with all coordinates was found: `rms`, `worst`, `relative`
                and `strain` are infinite
    """

    displacement: np.ndarray
    deformation: np.ndarray
    size: float
    strain: float
    second: float
    known: bool = True

    def __post_init__(self) -> None:
        for name in ("displacement", "deformation"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def rms(self) -> float:
        """Root-mean-square error over the nodes, unit of length."""
        return float(np.sqrt(np.mean(np.sum(self.displacement**2, axis=1)))) if self.known else np.inf

    @property
    def worst(self) -> float:
        """Error of the worst node, unit of length."""
        return float(np.linalg.norm(self.displacement, axis=1).max()) if self.known else np.inf

    def plain(self) -> dict[str, float | int | None]:
        """The values for a report; None where they are not finite."""
        numbers = {
            "rms": self.rms,
            "worst": self.worst,
            "largest displacement": self.size,
            "relative": self.relative,
            "strain": self.strain,
            "second sweep": self.second,
        }
        worst = int(np.argmax(np.linalg.norm(self.displacement, axis=1))) if self.known else None
        return {what: value if np.isfinite(value) else None for what, value in numbers.items()} | {
            "worst node": worst
        }

    @property
    def relative(self) -> float:
        """Error of the worst node relative to the largest displacement `size`; zero if `size` is zero."""
        return self.worst / self.size if self.size > 0 else 0.0


@dataclass(frozen=True, eq=False)
class FullEquilibrium:
    """The equilibrium of a machine with all coordinates of its reduced bodies.

    found : RestingState | None     None if the search found no equilibrium
    bases : ReductionBasis          of the reduced bodies, by name
    began : (n,), by name           all coordinates of these bodies at the equilibrium of the reduced machine
    second : float                  ratio of the second sweep to the first
    """

    found: RestingState | None
    bases: Mapping[str, ReductionBasis]
    began: Mapping[str, np.ndarray]
    second: float


def known_fulls(
    system: System, fulls: Mapping[str, FullBody] | Sequence[FullBody] | None = None
) -> dict[str, FullBody]:
    """Full bodies by name: those given, or by default (None) those that the reduced bodies refer to.

    Raises ModelError for a name that no reduced or full body of the machine has.
    """
    if fulls is None:
        reduced = system.bodies_of(ReducedBody)
        return {name: body.full for name, body in reduced.items() if body.full is not None}
    given = dict(fulls) if isinstance(fulls, Mapping) else {full.name: full for full in fulls}
    for name in given:
        body = system.placed(name, "fulls").body
        if body.kind not in ("reduced", "full"):
            raise ModelError(
                f"fulls: body '{name}' is {body.kind}, but errors at rest are estimated for reduced bodies "
                "only: leave it out"
            )
    return given


def full_rest(
    reduced: RestingState, fulls: Mapping[str, FullBody], time: float, search: StaticSearch
) -> FullEquilibrium | None:
    """The equilibrium with all coordinates, found from the reduced one; None without full bodies in `fulls`.

    fulls : full bodies of reduced bodies, by name; other bodies are unchanged
    Raises ModelError for a full body that does not belong to the reduced body of its name.
    """
    bases = stored_bases(reduced.system, fulls)
    if not bases:
        return None
    expanded = _expanded(reduced, bases, fulls)
    bodies = tuple(
        placed.in_form(fulls[placed.body.name], bases[placed.body.name].vectors)
        if placed.body.name in bases
        else placed
        for placed in reduced.system.bodies
    )
    turning = reduced.turning if np.any(reduced.turning.angular_velocities) else None
    whole = replace(reduced.system, bodies=bodies)
    machine = lines_in_frames(with_held_servos(whole, turning, time))
    statics = full_statics(machine, turning, time, reduced.equations.model.active)
    # Frame conditions transmit no force: the frame's own six equations balance the sum of the nodal forces.
    start = reduced.state._replace(
        configuration=reduced.configuration._replace(coordinates=np.concatenate(expanded)),
        frame_multipliers=statics.start().frame_multipliers,
    )
    names = [placed.body.name for placed in bodies]
    began = {name: own for name, own in zip(names, expanded, strict=True) if name in bases}
    lowest = min(reduced.system.bodies_of(ReducedBody)[name].lowest_frequency() for name in bases)
    state, second = _swept(statics, start, time, (SLOWNESS / lowest) ** 2)
    if state is None:
        try:
            state, _ = search_equilibrium(
                statics, start, time, replace(search, max_iterations=min(NEAR_BY, search.max_iterations))
            )
        except ConvergenceError:
            # The equilibrium is far from the reduced one: the undeformed shape is an equally good start.
            statics = full_statics(machine, turning, time)
            try:
                state, _ = search_equilibrium(statics, statics.start(), time, search)
            except ConvergenceError:
                return FullEquilibrium(None, bases, began, second)
    system = replace(statics.machine.system, loads=whole.loads, controllers=whole.controllers)
    found = reduced._replace(system=system, state=state, equations=statics)
    return FullEquilibrium(found, bases, began, second)


def rest_errors(
    reduced: RestingState, fulls: Mapping[str, FullBody], full: FullEquilibrium
) -> dict[str, EquilibriumError]:
    """The basis error of each body, by name."""
    held = fixes_rigid_motion(reduced.system, reduced.equations.model)
    before = placed_at_rest(reduced).bodies
    after = before if full.found is None else placed_at_rest(full.found).bodies
    errors = {}
    for old, new in zip(before, after, strict=True):
        name = old.body.name
        if name not in full.bases:
            continue
        own, began = fulls[name], full.began[name]
        if full.found is None:
            none, size = np.zeros_like(began), largest_displacement(own, began[None])
            errors[name] = EquilibriumError(
                np.zeros_like(own.nodes), none, size, np.inf, full.second, known=False
            )
            continue
        deformation = new.coordinates - full.bases[name].vectors @ old.coordinates
        if held:
            displacement = new.positions() - old.positions()
        else:
            missing = new.coordinates - began  # condensed motion is not an error
            displacement = own.expand(frame_projector(own.body, MeanAxisFrame())(missing))
        size, strain = largest_displacement(own, new.coordinates[None]), _strain(own, began, new.coordinates)
        largest = max(size, float(np.linalg.norm(displacement, axis=1).max()))
        if largest <= ROUND_OFF * np.ptp(own.nodes, axis=0).max():  # undeformed: ratios of rounding errors
            displacement, size, strain = np.zeros_like(displacement), 0.0, 0.0
        errors[name] = EquilibriumError(displacement, deformation, size, strain, full.second)
    return errors


def fixes_rigid_motion(system: System, model: Model) -> bool:
    """Whether the joints determine all rigid motion."""
    return len(model.active) >= 6 * len(system.bodies)


def _expanded(
    reduced: RestingState, bases: Mapping[str, ReductionBasis], fulls: Mapping[str, FullBody]
) -> list[np.ndarray]:
    """All coordinates of each body at equilibrium, with the condensed motion."""
    coordinates, first, forms = [], 0, reduced.system.bodies_of(ReducedBody)
    for placed in reduced.system.bodies:
        body = placed.body
        own = np.asarray(reduced.configuration.coordinates[first : first + body.n_coordinates])
        first += body.n_coordinates
        if body.name in bases:
            basis = bases[body.name]
            gamma, own = own[None], basis.vectors @ own
            if forms[body.name].condensed is not None:
                own = own + Condensation(fulls[body.name].body, basis).bilinear(gamma, gamma)[:, 0]
        coordinates.append(own)
    return coordinates


def _swept(
    statics: FullStatics, state: StaticState, time: float, k: float
) -> tuple[StaticState | None, float]:
    """State corrected by sweeps with one factor, None without contraction; second sweep over the first."""
    scale, before, first, second = statics.position_scale, np.inf, 0.0, 0.0
    found = statics.unbalance(state, time)
    try:
        tangent = statics.tangent(found, k)
    except AccuracyError:
        return None, np.inf
    for sweep in range(MOST_SWEEPS):
        change = tangent.correction(found)
        size = float(np.max(abs(change.increment) / scale))
        rate, before = size / before, size
        if sweep == 0:
            first = size
        elif sweep == 1:
            second = rate
        if not np.isfinite(size) or rate > CONTRACTS:
            return None, second
        state = moved_state(statics, state, change)
        if size <= max(CONVERGED * first, NOTHING):
            return state, second
        found = statics.unbalance(state, time)
    return state, second


def _strain(full: FullBody, before: np.ndarray, after: np.ndarray) -> float:
    """Square root of the work of missing forces on the missing deformation, relative to the total work."""
    force = full.body.force.internal_force
    whole = abs(after @ force(after))
    missing = abs((after - before) @ (force(after) - force(before)))
    return float(np.sqrt(missing / whole)) if whole else 0.0

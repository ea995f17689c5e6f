"""The 61.5 m blade in equilibrium under one to three times its mean wind load, by seven methods.

The load is dead, on the nodes of the leading edge; the root is clamped. The error is the distance between the
tip displacements of a method and of the full model in mean axes, over the displacement of the full model. At
the mean wind load CalculiX, which uses no floating frame, differs from the full model by 0.15 %
(docs/blade_benchmark.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from time import process_time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from supple.body import (
    AveragingInterface,
    BodyForm,
    FlexibleBody,
    Frame,
    FullBody,
    MeanAxisFrame,
    NodalFixedFrame,
    RigidInterface,
    flexible_body,
)
from supple.equations import StaticSearch
from supple.errors import ConvergenceError
from supple.fem import GREEN_LAGRANGE, FiniteElementModel, shell_model
from supple.machine import DeadForce, Fixed, Placed, System, split_body
from supple.mesh import AlongAxis
from supple.methods.intrinsic import LoadPath, condense
from supple.reduction import (
    AmplitudeProduct,
    CompressedDerivatives,
    CraigBampton,
    NoLoads,
    ReducedBody,
    Rubin,
    StaticCorrection,
    StaticLoad,
    reduce,
)
from supple.simulation.equilibrium import equilibrium
from supple_benchmarks.nrel5mw_blade import BODY, COARSE_GRID, RATED, SECTION, Blade
from supple_benchmarks.table import Row

__all__ = ["blade_rows"]

Array = NDArray[np.float64]

ENDS = (RigidInterface("root", "root"), AveragingInterface("tip", "tip"))
N_PARTS = 4
SEARCH = StaticSearch(max_iterations=60)
CLAMP = Fixed(first="ground", second=f"{BODY}.root", name="clamp")
REFERENCE = "full, mean-axis"


class ClampedBlade(NamedTuple):
    """The blade clamped at its root, and a load on its nodes.

    nodes : (k,) loaded nodes;   tip : nodes of the tip
    forces : (k, 3) N, `factor` times the mean wind load
    """

    model: FiniteElementModel
    body: FlexibleBody
    nodes: NDArray[np.int64]
    factor: float
    forces: Array
    tip: NDArray[np.int64]

    def system(self, form: BodyForm | Placed, share: float = 1.0) -> System:
        """The system with the blade as `form`, under the fraction `share` of the load."""
        return System([form], [CLAMP], [DeadForce(body=BODY, at=self.nodes, force=share * self.forces)])

    @property
    def nodal(self) -> Array:
        """The load as a vector (n_nodal,) of nodal freedoms."""
        vector = np.zeros((len(self.body.nodes), self.body.dofs_per_node))
        vector[self.nodes, :3] = self.forces
        return vector.ravel()


def blade_rows(quick: bool) -> Iterator[Row]:
    """One row per load and method.

    The error is None if the method or the full model in mean axes finds no equilibrium.
    """
    blade = Blade(COARSE_GRID) if quick else Blade()
    n_stations, n_modes = (13, 60) if quick else (31, 80)
    model = shell_model(blade.mesh, SECTION, kinematics=GREEN_LAGRANGE)
    body = flexible_body(BODY, model, ENDS)
    wind, tip = blade.mean_wind(RATED), np.asarray(blade.mesh.nodes_of("tip"))
    methods: dict[str, Callable[[ClampedBlade], Array]] = {
        REFERENCE: lambda clamped: _full(clamped, MeanAxisFrame()),
        "full, nodal-fixed": lambda clamped: _full(clamped, NodalFixedFrame("root")),
        "floating, mean-axis": lambda clamped: _floating(clamped, MeanAxisFrame()),
        "floating, nodal-fixed": lambda clamped: _floating(clamped, NodalFixedFrame("root")),
        "split, full": lambda clamped: _split(clamped, lambda part, _, frame: FullBody(part, frame)),
        "split, reduced": lambda clamped: _split(clamped, _reduced),
        "intrinsic": lambda clamped: _intrinsic(clamped, n_stations, n_modes),
    }
    for factor in (1, 3) if quick else (1, 1.4, 3):
        clamped = ClampedBlade(model, body, blade.leading_edge, factor, factor * wind, tip)
        exact: Array | None = None
        rotation: float | None = None
        for method, places in methods.items():
            began = process_time()
            error: float | None = None
            tip_moved: list[float] | None = None
            with suppress(ConvergenceError):
                at = places(clamped)
                moved = (at - body.nodes[tip]).mean(axis=0)
                rotation = rotation or _turn(body.nodes[tip], at)  # by the first method with an equilibrium
                if method == REFERENCE:
                    exact = moved
                if exact is not None:
                    error = float(np.linalg.norm(moved - exact) / np.linalg.norm(exact))
                tip_moved = moved.tolist()
            yield {
                "body": "blade",
                "load": factor,
                "tip_rotation": rotation,
                "method": method,
                "error": error,
                "tip": tip_moved,
                "seconds": process_time() - began,
            }


def _turn(rest: Array, moved: Array) -> float:
    """Rotation angle of the nodes of a section, rad, by least squares."""
    found = Rotation.align_vectors(moved - moved.mean(axis=0), rest - rest.mean(axis=0))[0]
    return float(found.magnitude())


def _full(clamped: ClampedBlade, frame: Frame) -> Array:
    return _rested(clamped, FullBody(clamped.body, frame))


def _floating(clamped: ClampedBlade, frame: Frame) -> Array:
    return _rested(clamped, _reduced(clamped.body, clamped.nodal, frame))


def _reduced(body: FlexibleBody, nodal: Array, frame: Frame) -> ReducedBody:
    linear = CraigBampton(8) if isinstance(frame, NodalFixedFrame) else Rubin(14)
    return reduce(
        body,
        frame,
        StaticCorrection(linear, nodal[:, None]),
        derivatives=CompressedDerivatives(15, weights=AmplitudeProduct(StaticLoad(nodal))),
        loads=NoLoads,
    )


def _rested(clamped: ClampedBlade, form: BodyForm) -> Array:
    """Positions of the tip nodes in equilibrium; the load is increased in steps."""
    placed = Placed(form)
    for share in _shares(clamped):
        (placed,) = equilibrium(clamped.system(placed, share), search=SEARCH, fulls=()).system.bodies
    return placed.positions(clamped.tip)


def _split(clamped: ClampedBlade, form: Callable[[FlexibleBody, Array, Frame], BodyForm]) -> Array:
    """Positions of the tip nodes of four bodies in a chain; the load is increased in steps.

    The frame of each body is fixed to its inner end.
    """
    split = split_body(BODY, clamped.model, AlongAxis(N_PARTS, (0, 0, 1)), ENDS)
    bodies, loads = [], []
    carried = np.zeros(len(clamped.nodes), dtype=bool)
    for number, (part, members) in enumerate(zip(split.parts, split.mesh.parts, strict=True)):
        own = np.isin(clamped.nodes, members.nodes) & ~carried
        carried |= own
        nodes = members.numbers(clamped.nodes[own])
        nodal = np.zeros((len(part.nodes), part.dofs_per_node))
        nodal[nodes, :3] = clamped.forces[own]
        inner = "root" if number == 0 else f"cut-{number}"
        bodies.append(Placed(form(part, nodal.ravel(), NodalFixedFrame(inner))))
        loads.append((part.name, nodes, clamped.forces[own]))
    clamp = Fixed(first="ground", second=f"{bodies[0].body.name}.root", name="clamp")
    for share in _shares(clamped):
        forces = [DeadForce(body=name, at=nodes, force=share * force) for name, nodes, force in loads]
        system = System(bodies, [clamp, *split.joints], forces)
        bodies = list(equilibrium(system, search=SEARCH, fulls=()).system.bodies)
    return bodies[-1].positions(split.mesh.parts[-1].numbers(clamped.tip))


def _shares(clamped: ClampedBlade) -> Array:
    """Increasing fractions of the load, up to 1, in equal steps of at most the mean wind load."""
    n = int(np.ceil(clamped.factor))
    return np.arange(1, n + 1) / n


def _intrinsic(clamped: ClampedBlade, n_stations: int, n_modes: int) -> Array:
    body = condense(clamped.body, LoadPath("root", "tip", n_stations), n_modes=n_modes)
    rest = equilibrium(clamped.system(body)).solution.bodies[BODY]
    return body.positions(rest, clamped.tip)[0]

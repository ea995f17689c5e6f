"""A bar hits a wall and its nose is crushed; the rest vibrates, modelled by elements or by modes."""

from __future__ import annotations

from collections.abc import Sequence
from time import process_time

import jax
import numpy as np

from supple.body import AveragingInterface, flexible_body
from supple.fem import FiniteElementModel, Isotropic, solid_model
from supple.integrate import Run, run
from supple.machine import (
    At,
    Contact,
    Placed,
    RigidPlane,
    System,
    Tie,
)
from supple.mesh import CellType, Mesh, block
from supple.methods.explicit import (
    ExplicitEngine,
    J2Plasticity,
    LinearHardening,
    NodalMotion,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import Rubin
from supple_benchmarks.table import Row

__all__ = ["crash"]

ALUMINIUM = Isotropic(70e9, 0.3, 2700.0)
SPEED = np.array([30.0, 0.0, 0.0])
_NOSE, _REST = "nose", "rest"


def _models(n: int, long: int) -> tuple[FiniteElementModel, FiniteElementModel]:
    """The models of the rest, 1 m of tetrahedra, and of the nose, 0.2 m of hexahedra.

    Both have the same grid in the cross-section: n x n cells.
    """
    rest = block(1.0, 0.1, 0.1, long, n, n, CellType.TETRA4)
    nose = block(0.2, 0.1, 0.1, max(n, 2), n, n, CellType.HEXA8)
    moved = Mesh(nose.nodes + np.array([1.0, 0.0, 0.0]), nose.cells, nose.node_sets)
    return solid_model(rest, ALUMINIUM), solid_model(moved, ALUMINIUM)


_REPETITIONS = 3


def _size(engine: ExplicitEngine) -> float:
    """Bytes of the arrays of an engine: its model and its initial state."""
    leaves = jax.tree.leaves((engine.built.model, engine.built.start))
    return sum(np.asarray(leaf).nbytes for leaf in leaves)


def _seconds(engines: Sequence[ExplicitEngine], span: Run) -> list[float]:
    """Processor seconds of a run of each engine, without compilation.

    The engines run in turn, `_REPETITIONS` times; the smallest time of each engine is returned.
    """
    seconds = []
    for _ in range(_REPETITIONS):
        seconds.append([])
        for engine in engines:
            began = process_time()
            run(engine, span.times)
            seconds[-1].append(process_time() - began)
    return np.min(seconds, axis=0).tolist()


def crash(quick: bool) -> dict[str, float]:
    """Cost and error of the bar with a modal rest, compared with the bar of elements.

    full_s, modal_s : processor seconds with all elements, and with the modal rest; speedup : their ratio
    error : largest distance between equal nodes of the two models, over the largest displacement
    memory_ratio : bytes with all elements over bytes with the modal rest
    """
    n, long = (4, 40) if quick else (8, 80)
    rest, nose = _models(n, long)
    law = J2Plasticity(ALUMINIUM, LinearHardening(100e6, 300e6))
    crushing = Placed(explicit_subdomain(nose, law, name=_NOSE), velocity=SPEED)
    # Rubin adds six columns to the 24 modes: the static responses to forces and moments at the joint. For an
    # equal number of modes they halve the error.
    body = flexible_body(_REST, rest, [AveragingInterface("tip", "tip")])
    modal = modal_subdomain(body, Rubin(24))
    common: Row = {
        "ties": [Tie(At(_NOSE, "root"), _REST)],
        "contacts": [Contact(At(_NOSE, "tip"), RigidPlane((1.2, 0.0, 0.0), (-1.0, 0.0, 0.0)))],
    }
    span = Run(1.2e-3, 1.2e-4)
    whole = System([Placed(explicit_subdomain(rest, name=_REST), velocity=SPEED), crushing], **common)
    reduced = System([Placed(modal, velocity=SPEED), crushing], **common)
    engines = [ExplicitEngine(system, span) for system in (whole, reduced)]
    full, own = (run(engine, span.times) for engine in engines)  # includes compilation
    full_s, modal_s = _seconds(engines, span)
    positions = modal.positions(own.bodies[_REST])
    nodes = {name: full.motion(name, NodalMotion).nodes for name in (_REST, _NOSE)}
    off = max(
        float(np.linalg.norm(positions - nodes[_REST], axis=2).max()),
        float(np.linalg.norm(own.motion(_NOSE, NodalMotion).nodes - nodes[_NOSE], axis=2).max()),
    )
    moved = max(float(np.linalg.norm(each - each[:1], axis=2).max()) for each in nodes.values())
    return {
        "full_s": full_s,
        "modal_s": modal_s,
        "speedup": full_s / modal_s,
        "error": off / moved,
        "memory_ratio": _size(engines[0]) / _size(engines[1]),
    }

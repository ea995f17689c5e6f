"""A machine with one flexible body, to be run with that body unreduced or reduced in several ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from supple.body import FlexibleBody, Frame, FullBody, MeanAxisFrame
from supple.fem import FiniteElementModel, Isotropic
from supple.integrate import Solution
from supple.machine import System
from supple.mesh import Mesh
from supple.reduction import ReducedBody
from supple.results.camera import Camera

__all__ = ["FlexibleMachine"]


@dataclass(frozen=True, eq=False)
class FlexibleMachine:
    """Interface of a machine to the study of tolerances.

    name : str                     of the benchmark, "quadruple-pendulum"
    body : FlexibleBody            linear: displacements against its frame stay small
    model, material                what it is made of, for its stress
    system : callable              the machine with a given variant of the body in it
    work : callable                what was put into the machine until each output time (t,), J
    looks : {name: Mesh}           of the rigid bodies, for pictures
    point : int                    node A, whose motion and stress are compared
    size : m                       a length of the machine, 1 % of which counts as far apart
    n_modes : int                  N_m, modal coordinates kept of every basis
    duration, output_step : s      step : s, of the runs that are compared
    settled : s                    from then on errors are ordered: by then the steps have damped what a jump
        of the load at the start rang in modes that they are too long to resolve
    camera : Camera                from where the machine is seen
    """

    name: str
    body: FlexibleBody
    model: FiniteElementModel
    material: Isotropic
    system: Callable[[FullBody | ReducedBody], System]
    work: Callable[[Solution], np.ndarray]
    looks: Mapping[str, Mesh]
    point: int
    size: float
    n_modes: int
    duration: float
    output_step: float
    step: float
    settled: float
    camera: Camera

    @property
    def frame(self) -> Frame:
        """Mean axes, whose modes are the free-free ones of [Han2020]."""
        return MeanAxisFrame()

    @property
    def label(self) -> str:
        """Machine, mesh and duration, as a file name."""
        cells = self.model.mesh.only_cell_type().name.lower()
        return f"{self.name}_{self.model.mesh.n_cells}-{cells}_{self.duration:g}s"

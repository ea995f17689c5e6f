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
    """A machine with one flexible body, for the study of tolerances.

    name : str                     of the benchmark, "quadruple-pendulum"
    body : FlexibleBody            linear: displacements relative to its frame stay small
    model, material                finite element model and material, for its stress
    system : callable              the machine with a given variant of the body
    work : callable                external work on the machine until each output time (t,), J
    looks : {name: Mesh}           meshes of the rigid bodies, for pictures
    point : int                    node A, whose motion and stress are compared
    size : m                       a length of the machine; runs that differ by 1 % of it have diverged
    n_modes : int                  N_m, number of modal coordinates of every basis
    duration, output_step : s      step : s, of the runs that are compared
    compared_from : s              errors are compared from this time on: a jump of the load at the start
        excites modes that the steps do not resolve, and the integration has damped them by then
    camera : Camera                view of the machine
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
    compared_from: float
    camera: Camera

    @property
    def frame(self) -> Frame:
        """Mean axes, with the free-free modes of [Han2020]."""
        return MeanAxisFrame()

    @property
    def label(self) -> str:
        """Machine, mesh and duration, as a file name."""
        cells = self.model.mesh.only_cell_type().name.lower()
        return f"{self.name}_{self.model.mesh.n_cells}-{cells}_{self.duration:g}s"

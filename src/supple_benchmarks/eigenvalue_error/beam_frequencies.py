"""Frequencies of the free cylinder by solid elements compared with those of beam theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from supple.body import AveragingInterface, FlexibleBody, flexible_body
from supple.fem import solid_model
from supple.mesh import cylinder
from supple_benchmarks.eigenvalue_error.free_beam import RoundBeam
from supple_benchmarks.eigenvalue_error.problem import ELEMENTS, EigenvalueErrors
from supple_benchmarks.han2020_bodies import LENGTH, RADIUS, STEEL_LIKE

__all__ = ["BeamFrequency", "beam_frequencies"]

Array = np.ndarray


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
        """Excess of the frequency, relative to the beam's."""
        return self.computed / self.theory - 1.0


def beam_frequencies(
    problem: EigenvalueErrors, n_bending: int = 3, n_torsion: int = 2
) -> list[BeamFrequency]:
    """The lowest bending and torsional frequencies of the free cylinder on several meshes."""
    beam = RoundBeam(LENGTH, RADIUS, STEEL_LIKE)
    rows = []
    for element, counts in problem.beams:
        mesh = cylinder(RADIUS, LENGTH, *counts, element)
        # An averaging interface leaves the section flexible: a rigid end would stiffen it.
        body = flexible_body("cylinder", solid_model(mesh, STEEL_LIKE), [AveragingInterface("end", "tip")])
        n_modes = 2 * n_bending + 2 * n_torsion + 4
        modes = body.lowest_modes(n_modes, (body.mass @ body.rigid_modes).T)
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
    """Torsion, extension or bending, by the share of the motion around or along the axis."""
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

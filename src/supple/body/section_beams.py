"""A chain of beam elements from a section table."""

from __future__ import annotations

import numpy as np

from supple.arguments import checked_arguments
from supple.arrays import FloatArray
from supple.errors import ModelError
from supple.fem import CoupledBeamSection, FiniteElementModel, Section, finite_element_model
from supple.importers import SectionTable
from supple.mesh import CellType, Mesh

__all__ = ["section_beams"]


@checked_arguments
def section_beams(table: SectionTable, n_elements: int | None = None) -> FiniteElementModel:
    """A chain of straight, tapering beam elements with the coupled sections of a table.

    Parameters
    ----------
    n_elements : int    number of elements of equal length; None: one element between adjacent table sections

    Returns
    -------
    FiniteElementModel  with the node sets "root" and "tip"; node numbers increase from root to tip

    Raises
    ------
    ModelError      fewer than one element
    """
    if n_elements is not None and n_elements < 1:
        raise ModelError(f"a chain of beams needs at least one element, not {n_elements}")
    ends = table.lengths if n_elements is None else np.linspace(0, table.lengths[-1], n_elements + 1)
    points, axes, stiffness, inertia = table.at(ends)
    n = len(ends) - 1
    towards = table.at(0.5 * (ends[1:] + ends[:-1]))[1][:, :, 0]
    x = np.diff(points, axis=0)
    x = x / np.linalg.norm(x, axis=1)[:, None]
    z = np.cross(x, towards)
    z = z / np.linalg.norm(z, axis=1)[:, None]
    beam = np.stack([x, np.cross(z, x), z], axis=1)

    def along_beams(matrices: FloatArray, end: int) -> FloatArray:
        """Section matrices (n, 6, 6) at the first (0) or second (1) end of each beam, in the beam's axes."""
        own = slice(end, n + end)
        turn = np.zeros((n, 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = beam @ axes[own]
        turned = turn @ matrices[own] @ turn.swapaxes(1, 2)
        return 0.5 * (turned + turned.swapaxes(1, 2))

    first, second = (zip(along_beams(stiffness, e), along_beams(inertia, e), strict=True) for e in (0, 1))
    mesh = Mesh(
        points,
        {CellType.LINE2: np.column_stack([np.arange(n), np.arange(1, n + 1)])},
        node_sets={"root": np.array([0]), "tip": np.array([n])},
    )
    sections = tuple(
        Section(
            CellType.LINE2,
            np.array([k]),
            CoupledBeamSection(*here, second=CoupledBeamSection(*there)),
            directions=towards[k : k + 1],
        )
        for k, (here, there) in enumerate(zip(first, second, strict=True))
    )
    return finite_element_model(mesh, sections)

"""A beam of line elements as a chain of full bodies, each with a floating frame of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.body import FullBody, NodalFixedFrame, RigidInterface, flexible_body
from supple.fem import BeamSection, Isotropic, shell_model
from supple.machine import GROUND, At, Fixed, Joint, Placed
from supple_benchmarks.lines import line_mesh

__all__ = ["BeamChain", "beam_chain", "rectangle"]


def rectangle(
    material: Isotropic, y: float, z: float, torsion: float, orientation: ArrayLike = (0, 1, 0)
) -> BeamSection:
    """A rectangular section, y by z, m; `torsion`: torsion constant, m^4; `orientation`: direction of y."""
    return BeamSection(
        material, y * z, z * y**3 / 12, y * z**3 / 12, torsion, 5 / 6, 5 / 6, orientation=orientation
    )


@dataclass(frozen=True, eq=False)
class BeamChain:
    """Bodies from the root to the tip; joints between them and, for a clamped beam, at the root."""

    bodies: tuple[Placed, ...]
    joints: tuple[Joint, ...]

    @property
    def tip(self) -> At:
        """The interface "tip" of the last body."""
        return At(self.bodies[-1].body.name, "tip")


def beam_chain(nodes: ArrayLike, section: BeamSection, n_bodies: int, *, clamped: bool = True) -> BeamChain:
    """A beam along nodes (N, 3) as bodies fixed to each other and, if `clamped`, to the ground.

    n_bodies : at most N - 1, the number of elements
    """
    places = np.asarray(nodes, dtype=float)
    parts: list[NDArray[np.float64]] = [
        places[part[0] : part[-1] + 2] for part in np.array_split(np.arange(len(places) - 1), n_bodies)
    ]
    ends = (RigidInterface("root", "root"), RigidInterface("tip", "tip"))
    bodies = [
        FullBody(
            flexible_body(f"beam {k}", shell_model(line_mesh(part), section), ends), NodalFixedFrame("root")
        )
        for k, part in enumerate(parts)
    ]
    held = [Fixed(name="wall", first=GROUND, second=At("beam 0", "root"))] if clamped else []
    tied = [
        Fixed(name=f"tie {k}", first=At(f"beam {k - 1}", "tip"), second=At(f"beam {k}", "root"))
        for k in range(1, n_bodies)
    ]
    return BeamChain(tuple(Placed(body) for body in bodies), (*held, *tied))

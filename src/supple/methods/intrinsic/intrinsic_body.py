"""Slender body in its intrinsic modes, for use in a machine."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import ClassVar, Literal

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray

from supple.algebra import read_only
from supple.arrays import FloatArray
from supple.body import Damping
from supple.body.floating_kinematics import checked_nodes
from supple.body.form_defaults import FormDefaults
from supple.body.interface import UntiedInterface, interface_named
from supple.body.mass_properties import centre_of_gram
from supple.body.point_motion import InterfaceMotion, NodeMotion, frames_near
from supple.body.sections import CuttingPlane, Sections
from supple.errors import ModelError, SuppleWarning
from supple.fem import FiniteElementModel
from supple.integrate.motion import Motion
from supple.machine import Placed
from supple.methods.intrinsic.condensed_line import CondensedLine
from supple.methods.intrinsic.expansion import Expansion, expansion_of_stations
from supple.methods.intrinsic.intrinsic_modes import IntrinsicModes, intrinsic_modes
from supple.methods.intrinsic.intrinsic_motion import IntrinsicMotion
from supple.methods.intrinsic.line_equations import line_forces
from supple.methods.intrinsic.line_freedoms import LineFreedoms, line_freedoms
from supple.methods.intrinsic.line_model import LineModel, line_model
from supple.methods.intrinsic.root_support import RootSupport
from supple.methods.intrinsic.second_order_modes import (
    completed_modes,
    second_order_shapes,
    with_static_shapes,
)
from supple.methods.intrinsic.station_motion import StationMotion, station_motion
from supple.methods.intrinsic.strain_integration import StationPlaces, station_places
from supple.programs.program_cache import CachedProgram
from supple.summary import Summarized, Summary, place_text

__all__ = ["IntrinsicBody", "intrinsic_body"]


ROOM = 2**22
"""Largest number of components of rotations and positions in memory at a time."""


@dataclass(frozen=True, eq=False)
class Station(UntiedInterface):
    """Interface at a station.

    position : (3,)     in the body's axes
    motion : (6, e)     linear motion per unit elastic amplitude
    number : int        number of the station
    """

    name: str
    position: FloatArray
    motion: FloatArray
    number: int


@dataclass(frozen=True, eq=False, repr=False)
class IntrinsicBody(FormDefaults, Summarized):
    """Slender body with arbitrary rotations and bending, from its linear modes.

    Built by `intrinsic_body` or `condense`.

    modes : IntrinsicModes          on the support of its root
    expansion : Expansion           map from stations to nodes
    stations : name -> number       interfaces
    damping : Damping | None        ModalDamping or RayleighDamping; the ratios of ModalDamping, and alpha of
        RayleighDamping, belong to the modes on its root support, also for a released body
    complete : IntrinsicBody | None     the same body with all its modes; None if this body has all
    supported : IntrinsicBody | None    for a released body: the body before release, on its root support
    lumping_error : float | None    relative error, due to the lumped mass, of deflections under its weight;
        None for a line that is not condensed from elements
    """

    modes: IntrinsicModes
    expansion: Expansion = field(repr=False)
    stations: Mapping[str, int] = field(repr=False)
    damping: Damping | None = None
    complete: IntrinsicBody | None = field(default=None, repr=False)
    supported: IntrinsicBody | None = field(default=None, repr=False)
    lumping_error: float | None = None
    kind: ClassVar[Literal["intrinsic"]] = "intrinsic"
    is_linear: ClassVar[bool] = False
    """Its equations are quadratic."""
    has_linear_strains: ClassVar[bool] = True
    """Stress follows from the static shapes under its section loads."""
    rotation_limit: ClassVar[float] = np.inf
    """Rotations are not limited."""

    def summary(self) -> Summary:
        """Stations, modes, mass and interfaces."""
        lowest = ", ".join(f"{value:.4g}" for value in self.modes.frequencies[:6] / (2 * np.pi))
        rows = [
            ("modes", f"{self.n_coordinates} on {self.line.n} stations"),
            ("rigid motions of its root", f"{self.support.free.shape[1]} free"),
            ("mass", f"{self.mass:g}"),
            ("lowest frequencies", f"{lowest} cycles per unit of time"),
        ]
        size = float(abs(self.nodes).max())
        rows += [(f"interface {one.name}", f"at {place_text(one.position, size)}") for one in self.interfaces]
        return Summary(f"IntrinsicBody '{self.name}', {self.n_coordinates} modes", rows)

    @property
    def name(self) -> str:
        """Name of the body."""
        return self.line.name

    @property
    def line(self) -> CondensedLine:
        """Stiffness and mass on stations."""
        return self.modes.line

    @property
    def support(self) -> RootSupport:
        """Support of its root."""
        return self.modes.support

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return self.line.total_mass

    @property
    def centre_of_mass(self) -> FloatArray:
        """(3,) undeformed, in the mesh axes, m."""
        rigid = self.line.twists
        return self.line.tree.points[0] + centre_of_gram(rigid.T @ self.line.mass @ rigid)

    @property
    def n_coordinates(self) -> int:
        """Number of elastic modes, those of second order included."""
        return self.modes.n_elastic

    @property
    def nodes(self) -> FloatArray:
        """(N, 3) rest positions: those of the mesh, or of the stations."""
        return self.expansion.nodes

    @property
    def interfaces(self) -> tuple[Station, ...]:
        """Its named stations."""
        points = self.line.tree.points
        motions = self.modes.velocities[..., self.modes.n_rigid :]
        return tuple(Station(name, points[i], motions[i], i) for name, i in self.stations.items())

    def interface(self, name: str) -> Station:
        """Station by name; an unknown name raises ModelError with the nearest name, or all names."""
        return interface_named(self.name, name, self.interfaces)

    @cached_property
    def model(self) -> LineModel:
        """Arrays of its equations of motion."""
        return line_model(self.modes, self.damping, None if self.supported is None else self.supported.modes)

    @property
    def dofs_per_node(self) -> int:
        """Number of freedoms of a node."""
        return self.expansion.modes.shape[1]

    @property
    def nodal_basis(self) -> FloatArray:
        """(N d, e) linear displacements of the nodal freedoms by elastic amplitude."""
        return self.expansion.modes.reshape(-1, self.n_coordinates)

    def nodal_fields(
        self, coordinates: FloatArray, freedoms: NDArray[np.intp] | slice = slice(None)
    ) -> tuple[FloatArray, None]:
        """Linear displacements (N d, t) by elastic amplitudes (t, e), for strains alone, and None."""
        return self.nodal_basis[freedoms] @ coordinates.T, None

    def truncated(self, n_modes: int) -> IntrinsicBody:
        """The same body with its `n_modes` lowest elastic modes, and their second-order modes.

        Raises ModelError for less than one mode, or more modes than the body has.
        """
        whole = self.complete or self
        if not 0 < n_modes <= whole.n_coordinates:
            raise ModelError(
                f"body '{self.name}': {n_modes} elastic modes requested: request 1 to "
                f"{whole.n_coordinates}, the number of its modes with mass"
            )
        shapes = second_order_shapes(whole.modes, n_modes)
        return whole if shapes.shape[1] == whole.n_coordinates else whole._in_shapes(whole, shapes, n_modes)

    def with_static_responses(self) -> IntrinsicBody:
        """The same body with the static responses to forces and moments at root, tips and branching points.

        They are further Ritz vectors, for joints there. A body with all modes is unchanged.
        """
        whole, n_lowest = self.complete, self.n_coordinates - self.modes.n_second_order
        if whole is None:
            return self
        shapes = second_order_shapes(whole.modes, n_lowest)
        shapes = with_static_shapes(whole.modes, shapes, n_lowest, self.line.tree.ends)
        if shapes.shape[1] == whole.n_coordinates:
            return replace(self, modes=whole.modes, expansion=whole.expansion, complete=None)
        return self._in_shapes(whole, shapes, n_lowest)

    def _in_shapes(self, whole: IntrinsicBody, shapes: FloatArray, n_lowest: int) -> IntrinsicBody:
        """The body in some shapes of all its modes; see `completed_modes`."""
        expansion = replace(
            whole.expansion,
            modes=read_only(whole.expansion.modes @ shapes),
            warping=read_only(whole.expansion.warping @ shapes),
        )
        modes = completed_modes(whole.modes, shapes, n_lowest)
        return replace(self, modes=modes, expansion=expansion, complete=whole)

    def forces_of(self, coordinates: ArrayLike) -> FloatArray:
        """Amplitudes q_2 (..., e) of the internal forces from elastic amplitudes (..., e)."""
        return -np.asarray(coordinates) * self.modes.omega[self.modes.n_rigid :]

    def expand(self, coordinates: ArrayLike, nodes: NDArray[np.intp] | slice = slice(None)) -> FloatArray:
        """Linear displacements (..., k, 3) of elastic amplitudes (..., e), with the root on its support."""
        return np.einsum("nie,...e->...ni", self.expansion.modes[nodes, :3], np.asarray(coordinates))

    def places(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        """Rotations (t, n, 3, 3) and positions (t, n, 3) of the stations in space."""
        own = motion.of_type(IntrinsicMotion)
        root = own.position + np.einsum("tij,j->ti", own.rotation, self.line.tree.points[0])
        found = _places(self.model, self.forces_of(own.coordinates), own.rotation, root)
        return np.asarray(found.rotations), np.asarray(found.positions)

    def positions(self, motion: Motion, nodes: ArrayLike | slice = slice(None)) -> FloatArray:
        """Positions (t, k, 3) in space of some nodes, or all, by `Expansion`."""
        given = nodes if isinstance(nodes, slice) else checked_nodes(nodes, len(self.nodes))
        chosen = np.arange(len(self.nodes))[given]
        arms, own = self.expansion.arms(self.line.tree)[chosen], self.expansion.stations[chosen]
        weights, warping = self.expansion.weights[chosen], self.expansion.warping[chosen]
        rotations, positions = self.places(motion)
        amplitudes = motion.of_type(IntrinsicMotion).coordinates
        rows = max(1, ROOM // (18 * max(len(chosen), 1)))
        result = np.empty((len(positions), len(chosen), 3))
        for first in range(0, len(positions), rows):
            part = slice(first, first + rows)
            bent = np.einsum("nie,te->tni", warping, amplitudes[part])
            moved = positions[part][:, own] + np.einsum(
                "tnwij,tnwj->tnwi", rotations[part][:, own], arms + bent[:, :, None]
            )
            result[part] = np.einsum("nw,tnwi->tni", weights, moved)
        return result

    def node_rotations(self, motion: Motion) -> FloatArray:
        """Rotation matrices (t, N, 3, 3) of nodes: for each, that of its station with the larger weight."""
        larger = self.expansion.weights.argmax(axis=1)
        return self.places(motion)[0][:, self.expansion.stations[np.arange(len(larger)), larger]]

    def station_motion(self, motion: Motion) -> StationMotion:
        """Positions, velocities and accelerations of the stations in space."""
        own = motion.of_type(IntrinsicMotion)
        return station_motion(self.model, self.line.tree.points[0], self.forces_of(own.coordinates), own)

    def node_motion(self, motion: Motion, nodes: ArrayLike) -> NodeMotion:
        """Positions, velocities and accelerations (t, k, 3) of some nodes in space, by `Expansion`.

        Accelerations are nan where the motion has none.
        """
        chosen = checked_nodes(nodes, len(self.nodes))
        own, weights = self.expansion.stations[chosen], self.expansion.weights[chosen]
        warping, arms = self.expansion.warping[chosen], self.expansion.arms(self.line.tree)[chosen]
        known, amplitudes = self.station_motion(motion), motion.of_type(IntrinsicMotion).coordinates
        omega = self.modes.omega[self.modes.n_rigid :]
        place, rate, second = (
            np.einsum("nie,te->tni", warping, q)[:, :, None]
            for q in (amplitudes, -known.strain_rates / omega, -known.strain_accelerations / omega)
        )
        place = place + arms

        def carried(places: StationPlaces, *terms: tuple[StationPlaces, FloatArray]) -> FloatArray:
            moved = places.positions[:, own]
            for by, local in terms:
                moved = moved + np.einsum("tnwij,tnwj->tnwi", by.rotations[:, own], local)
            return np.einsum("nw,tnwi->tni", weights, moved)

        A, dA, ddA = known.places, known.velocities, known.accelerations
        return NodeMotion(
            self.positions(motion, chosen),
            carried(dA, (dA, place), (A, rate)),
            carried(ddA, (ddA, place), (dA, 2 * rate), (A, second)),
        )

    def interface_motion(self, motion: Motion, name: str) -> InterfaceMotion:
        """Pose, velocities and acceleration (t, ...) of a named station in space."""
        number = self.interface(name).number
        known = self.station_motion(motion)

        def there(places: StationPlaces) -> tuple[FloatArray, FloatArray]:
            return np.asarray(places.positions[:, number]), np.asarray(places.rotations[:, number])

        (position, rotation), (velocity, turning) = there(known.places), there(known.velocities)
        spin = turning @ rotation.transpose(0, 2, 1)
        angular = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
        return InterfaceMotion(position, rotation, velocity, there(known.accelerations)[0], angular)

    def freedoms(self, q2: FloatArray) -> LineFreedoms:
        """Small motions of the line about a shape with force amplitudes q_2 (e,)."""
        return line_freedoms(self.model, self.support, self.line.tree.points[0], q2)

    def motion_near(
        self,
        position: FloatArray,
        rotation: FloatArray,
        coordinates: FloatArray,
        displacement: FloatArray,
        rates: FloatArray,
    ) -> IntrinsicMotion:
        """Motion with small displacements p (t, 6 + e), and velocities from their rates p' at p = 0."""
        frames = frames_near(position, rotation, displacement, rates)
        amplitudes = self.freedoms(self.forces_of(coordinates)).amplitudes(rates)
        still = np.zeros_like(frames[2]), np.zeros_like(frames[2]), np.zeros_like(amplitudes)
        return IntrinsicMotion(
            *frames[:2], coordinates + displacement[:, 6:], *frames[2:], amplitudes, *still
        )

    def sections(self, _model: FiniteElementModel | None = None) -> Sections:
        """Its cutting sections, which need no elements."""
        axes = f"axes of the section of {self.name}"
        return Sections(axes, partial(_section_loads, self), partial(_cut_segments, self))

    def section_loads(self, motion: Motion) -> FloatArray:
        """Internal forces and moments (t, n - 1, 6) at the middles of segments, along material axes.

        These are the elastic forces alone, without damping forces.
        """
        q2 = self.forces_of(motion.of_type(IntrinsicMotion).coordinates)
        return np.asarray(jax.vmap(lambda q: line_forces(self.model, q))(jnp.asarray(q2)))

    def stated_frequencies(self) -> tuple[str, FloatArray]:
        """Words for the support of the body before release, and its lowest six frequencies on it.

        Cycles per unit of time. A released body has the modes of the free body as its own.
        """
        own = self.supported or self
        held = "free" if own.support.free.shape[1] == 6 else "on its support"
        return held, own.modes.frequencies[:6] / (2 * np.pi)

    def lowest_frequency(self) -> float:
        """Lowest frequency of the elastic modes on its support, rad/s; infinite for a rigid body."""
        return float(self.modes.frequencies.min(initial=np.inf))


def _section_loads(body: IntrinsicBody, motion: Motion, plane: CuttingPlane) -> FloatArray:
    """Force and moment (t, 6) of the part beyond a plane on the part before it, along material axes.

    These are the section forces of the segment cut by the plane, with the moment about the point of the
    plane. If the plane contains a station, they are the mean of both adjacent segments.

    Warns SuppleWarning if the body keeps some of its modes only.

    Raises
    ------
    ModelError   a plane that cuts no segment, or several
    """
    if body.complete is not None:
        warnings.warn(
            f"body '{body.name}' keeps {body.n_coordinates} of its {body.complete.n_coordinates} modes: its "
            "section forces are inaccurate near concentrated loads and free ends, even if its positions are "
            "accurate. Keep all modes (omit their number), or compare with more modes",
            SuppleWarning,
            stacklevel=2,
        )
    found = []
    for segment, sense in _cut_segments(body, plane):
        loads = sense * body.section_loads(motion)[:, segment]
        arm = body.line.tree.middles[segment] - plane.point
        found.append(np.hstack([loads[:, :3], loads[:, 3:] + np.cross(arm, loads[:, :3])]))
    return np.mean(found, axis=0)


def _cut_segments(body: IntrinsicBody, plane: CuttingPlane) -> list[tuple[int, float]]:
    """The segment cut by a plane, or both at its station, with 1 if its outer end is beyond it, else -1.

    Raises ModelError as `_section_loads`.
    """
    tree = body.line.tree
    heights = plane.heights(tree.points)
    found = []
    for outside in (heights >= 0, heights > 0):
        segments = np.flatnonzero(outside[1:] != outside[tree.inner])
        if len(segments) > 1:
            raise ModelError(
                f"body '{body.name}': a section cuts one segment of its line, and the plane through "
                f"{plane.point} across {plane.normal} cuts {len(segments)}; turn its normal along the line"
            )
        found += [(int(segment), 1.0 if outside[segment + 1] else -1.0) for segment in segments]
    if not found:
        raise ModelError(
            f"body '{body.name}': the plane through {plane.point} across {plane.normal} cuts no segment "
            "of its line; move it, or turn its normal along the line"
        )
    return found


def body_of(placed: Placed) -> IntrinsicBody:
    """The intrinsic body that is placed; ModelError for another kind of body."""
    body = placed.body
    if not isinstance(body, IntrinsicBody):
        raise ModelError(
            f"body '{body.name}' is {body.kind}; this analysis supports intrinsic bodies only: use a time "
            "integration instead, with damping to reach equilibrium"
        )
    return body


def _places_over_time(
    model: LineModel, q2: jax.Array, rotations: jax.Array, positions: jax.Array
) -> StationPlaces:
    return jax.vmap(lambda *now: station_places(model, *now))(q2, rotations, positions)


_places = CachedProgram(_places_over_time)


def intrinsic_body(
    line: CondensedLine,
    support: RootSupport,
    n_modes: int | None = None,
    *,
    stations: Mapping[str, int] | None = None,
    damping: Damping | None = None,
) -> IntrinsicBody:
    """Intrinsic body whose nodes are the stations of a line.

    Parameters
    ----------
    n_modes : int       number of lowest elastic modes, extended by second-order modes; default all
    stations : name -> number   interfaces; "root", and "tip" of a line without branches, always exist

    Raises ModelError for a station that does not exist, and as `intrinsic_modes` and `truncated`.
    """
    modes = intrinsic_modes(line, support)
    ends = {"root": 0} | ({"tip": line.n - 1} if line.tree.is_chain and line.n > 1 else {})
    named = ends | dict(stations or {})
    for name, number in named.items():
        if not 0 <= number < line.n:
            raise ModelError(
                f"body '{line.name}': interface '{name}' is at station {number}; stations are 0 to "
                f"{line.n - 1}"
            )
    expansion = expansion_of_stations(line.tree, read_only(modes.velocities[..., modes.n_rigid :]))
    whole = IntrinsicBody(modes, expansion, named, damping)
    return whole if n_modes is None else whole.truncated(n_modes)

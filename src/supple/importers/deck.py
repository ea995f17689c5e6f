"""Deck: a finite-element model of another program, as described in its input file.

The deck readers of all formats return a Deck, from which `supple.body.deck_body` builds mesh, elements and
body. Values are in the units of the file; Pa, kg and m below are those of a file in SI units. Positions,
directions and freedoms are in the basic (global) axes of the file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from supple.arrays import BoolArray, FloatArray, IntArray
from supple.mesh import CellType, SectionGeometry


@dataclass(frozen=True)
class IsotropicMaterial:
    """E, Pa; nu; density, kg/m^3, 0 if none is given; G, Pa, None for E / (2 (1 + nu))."""

    youngs_modulus: float
    poissons_ratio: float
    density: float
    shear_modulus: float | None = None


@dataclass(frozen=True, eq=False)
class AnisotropicMaterial:
    """elasticity (6, 6), Pa, in material axes: strains xx yy zz yz xz xy (engineering); density, kg/m^3."""

    elasticity: FloatArray
    density: float


@dataclass(frozen=True, eq=False)
class SolidProperty:
    """Material of solid cells, in the axes `DeckElements.directions` or in basic axes if these are None."""

    material: IsotropicMaterial | AnisotropicMaterial


@dataclass(frozen=True)
class ShellProperty:
    """A homogeneous isotropic wall; offset: distance of its middle from the nodes along the cell normal.

    added_mass : non-structural, kg/m^2
    shear_factor : k of the transverse shear stiffness k G t; 0 if rigid
    """

    material: IsotropicMaterial
    thickness: float
    added_mass: float = 0.0
    offset: float = 0.0
    shear_factor: float = 0.0


@dataclass(frozen=True, eq=False)
class WallProperty:
    """A wall given by its stiffness: [N; M] = [A B; B D] [eps; kappa] about its reference surface (nodes).

    membrane, coupling, bending : (3, 3) A, N/m; B, N; D, N m; order xx, yy, xy
    shear : (2, 2) transverse shear stiffness, order xz, yz, N/m; None if rigid
    mass_per_area : kg/m^2;  rotary_inertia_per_area : kg, about the reference surface
    thickness : m, for pictures only; 0 if unknown
    mass_moment_per_area : first moment of the mass along the normal about the reference surface, kg/m
    lacks_density : whether a ply has no density, and the wall no non-structural mass
    """

    membrane: FloatArray
    coupling: FloatArray
    bending: FloatArray
    shear: FloatArray | None
    mass_per_area: float
    rotary_inertia_per_area: float
    thickness: float
    mass_moment_per_area: float = 0.0
    lacks_density: bool = False


@dataclass(frozen=True)
class BeamValues:
    """The section of a beam at one position, about its shear centre; y lies in plane 1, z in plane 2.

    I1, I2, I12 : second moments of area about the neutral axis for bending in planes 1, 2; product moment
    K1, K2 : shear factors of the planes, 0 if rigid in shear
    mass_per_length : with non-structural mass, kg/m
    neutral, mass_centre : (y, z) of the neutral axis and of the mass from the shear centre, m
    rotary : (Ixx, Iyy, Izz) per length about the mass centre, kg m; None: density times second moments
    geometry : outline and points of stress recovery, from the shear centre; None without them
    """

    area: float
    I1: float
    I2: float
    J: float
    K1: float
    K2: float
    mass_per_length: float
    I12: float = 0.0
    neutral: tuple[float, float] = (0.0, 0.0)
    mass_centre: tuple[float, float] = (0.0, 0.0)
    rotary: tuple[float, float, float] | None = None
    geometry: SectionGeometry | None = None


@dataclass(frozen=True)
class BeamProperty:
    """A beam of one material; a tapered one also has values at its second end, linear in between."""

    material: IsotropicMaterial
    first: BeamValues
    second: BeamValues | None = None


@dataclass(frozen=True)
class RodProperty:
    """A bar with stiffness in tension and torsion only; mass_per_length with non-structural mass, kg/m.

    torsion_arm : c of its shear stress c M_x / J, m
    """

    material: IsotropicMaterial
    area: float
    J: float
    mass_per_length: float
    torsion_arm: float = 0.0


Property = SolidProperty | ShellProperty | WallProperty | BeamProperty | RodProperty


@dataclass(frozen=True, eq=False)
class DeckElements:
    """Elements of one type and one property, as cells of this library.

    name : the type in the file (CQUAD4, C3D20R)
    kind : cell type; a quadrilateral becomes two triangles, a quadratic line two lines
    nodes : (C, k) node numbers, in the order of `kind`
    ids, lines : (C,) element id of each cell, and line of this element in the file
    property : key of `Deck.properties`
    directions : (C, 3) beams: a vector in plane 1; shells: its projection is the material's x axis.
                 (C, 3, 3) solids: the material's axes as columns. None if nothing depends on them
    offsets : (C, 2, 3) offsets of beam ends from their nodes
    released : (C, 12) released freedoms of beam ends, in the beam's axes
    reduced : whether HEXA20 cells have reduced integration
    incompatible : whether HEXA8 cells have incompatible modes
    mass_share : (C,) shells: ratio of the area with mass to the area of the cell; None if 1 everywhere
    """

    name: str
    kind: CellType
    nodes: IntArray
    ids: IntArray
    lines: IntArray
    property: str
    directions: FloatArray | None = None
    offsets: FloatArray | None = None
    released: BoolArray | None = None
    reduced: bool = False
    incompatible: bool = False
    mass_share: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class NodalMatrix:
    """Mass, stiffness or damping between freedoms of nodes: CONM2, DMIG, MASS.

    freedoms : (k,) 6 * node + component
    values : (k, k) symmetric
    """

    freedoms: IntArray
    values: FloatArray


@dataclass(frozen=True, eq=False)
class ScalarTerms:
    """Linear combinations of freedoms, one a row:  s = sum_j factor_j u_j,  j = 6 * node + component.

    With values k, c or m they are springs, dampers or masses: forces k s, c ds/dt, m d2s/dt2 along s. Without
    values they are constraints s = 0.

    rows : (T,) the row of each term;  freedoms, factors : (T,);  lines : (rows,) line of each row in the file
    values : (rows,) k, c or m; empty for constraints
    dependent : (rows,) the freedom that the file eliminates in a constraint, or -1
    """

    rows: IntArray
    freedoms: IntArray
    factors: FloatArray
    lines: IntArray
    values: FloatArray = field(default_factory=lambda: np.empty(0))
    dependent: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class RigidTie:
    """Nodes tied rigidly to a reference node in all freedoms (RBE2, RBAR, *RIGID BODY).

    name : such as rbe2_ID; also the name of its node set and interface
    """

    name: str
    reference: int
    nodes: IntArray
    line: int


@dataclass(frozen=True, eq=False)
class WeightedMean:
    """A reference node that follows the weighted mean motion of `nodes` (RBE3, distributing coupling).

    components : (6,) whether a component of the reference node follows the mean; otherwise it is free
    """

    name: str
    reference: int
    nodes: IntArray
    weights: FloatArray
    line: int
    components: tuple[bool, ...] = (True,) * 6


@dataclass(frozen=True)
class LeftOut:
    """Cards of one name that would change the body but are not read.

    count : number of cards;  line : of the first card;  meaning : consequence for the body
    """

    card: str
    count: int
    line: int
    meaning: str


@dataclass(frozen=True, eq=False)
class Deck:
    """A finite-element model as described in a file.

    nodes, node_ids : (N, 3), (N,) all nodes of the file, also those that no element uses
    node_sets : {name: (k,) numbers};  element_sets : {name: (k,) element ids}
    masses, stiffnesses, dampings : matrices between freedoms
    springs, dashpots, inertias : terms with values k, c, m;  constraints : terms without values
    held : constraints s = 0 by the supports in the file; a free body omits them
    read : {card: number} of cards that were read
    passed_over : {card: number} of cards without effect on a body
    left_out : cards that would change the body
    notes : assumptions of the reader, one sentence each
    superelements : {name: deck} of parts that can be separate bodies
    scalar_points : (S,) ids of points with one freedom and no position; point j has the node number N + j and
                    the component 0 in terms and matrices
    lumped_mass : whether the other program lumps the mass of elements
    """

    path: Path
    node_ids: IntArray
    nodes: FloatArray
    elements: tuple[DeckElements, ...]
    properties: Mapping[str, Property]
    node_sets: Mapping[str, IntArray] = field(default_factory=dict)
    element_sets: Mapping[str, IntArray] = field(default_factory=dict)
    masses: tuple[NodalMatrix, ...] = ()
    stiffnesses: tuple[NodalMatrix, ...] = ()
    dampings: tuple[NodalMatrix, ...] = ()
    springs: tuple[ScalarTerms, ...] = ()
    dashpots: tuple[ScalarTerms, ...] = ()
    inertias: tuple[ScalarTerms, ...] = ()
    constraints: tuple[ScalarTerms, ...] = ()
    held: tuple[ScalarTerms, ...] = ()
    rigid: tuple[RigidTie, ...] = ()
    means: tuple[WeightedMean, ...] = ()
    read: Mapping[str, int] = field(default_factory=dict)
    passed_over: Mapping[str, int] = field(default_factory=dict)
    left_out: tuple[LeftOut, ...] = ()
    notes: tuple[str, ...] = ()
    superelements: Mapping[str, Deck] = field(default_factory=dict)
    scalar_points: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    lumped_mass: bool = False

    def with_actions(
        self,
        matrix: Callable[[NodalMatrix], NodalMatrix | None],
        terms: Callable[[ScalarTerms], ScalarTerms],
    ) -> Deck:
        """The deck with its matrices and terms replaced by functions; None and empty terms are removed."""
        matrices = {
            name: tuple(new for old in getattr(self, name) if (new := matrix(old)) is not None)
            for name in ("masses", "stiffnesses", "dampings")
        }
        rows = {
            name: tuple(new for old in getattr(self, name) if len((new := terms(old)).lines))
            for name in ("springs", "dashpots", "inertias", "constraints", "held")
        }
        return replace(self, **matrices, **rows)

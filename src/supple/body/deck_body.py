"""Bodies from decks: mesh, elements, springs, masses and ties in another program's file."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from supple.arrays import FloatArray, IntArray
from supple.body.deck_parts import (
    deck_links,
    named_part,
    warn_of_scalar_points,
    with_scalar_points,
    without_scalar_points,
)
from supple.body.finite_element_body import flexible_body
from supple.body.flexible_body import FlexibleBody
from supple.body.interface import AveragingInterface, RigidInterface, connection_interface
from supple.body.rigid_motion import averaged_motion, nodal_rigid_modes
from supple.errors import ModelError, SuppleWarning
from supple.fem import (
    GREEN_LAGRANGE,
    Anisotropic,
    Attached,
    BeamSection,
    CellMass,
    Constraints,
    FiniteElementModel,
    HomogeneousSection,
    Isotropic,
    LaminateSection,
    RigidPiece,
    RodSection,
    Section,
    ShellKinematics,
    consistent_mass,
    finite_element_model,
    linear_strains,
)
from supple.importers import Connection
from supple.importers.deck import (
    AnisotropicMaterial,
    BeamProperty,
    BeamValues,
    Deck,
    DeckElements,
    IsotropicMaterial,
    NodalMatrix,
    Property,
    RodProperty,
    ScalarTerms,
    ShellProperty,
    SolidProperty,
    WallProperty,
    WeightedMean,
)
from supple.mesh import CellType, Mesh

__all__ = [
    "deck_body",
    "deck_connections",
    "deck_mesh",
    "deck_model",
    "missing_density",
    "refuse_omitted_cards",
]

# Largest accepted elongation of a spring in a rigid motion, relative to the terms that cancel.
_RIGID = 1e-6
# Sine of the angle between the normal and the material direction of a surface element. Up to this value the
# first side of the element replaces the direction.
_ALONG = 2e-3


def deck_body(
    name: str,
    deck: Deck,
    interfaces: Sequence[RigidInterface | AveragingInterface] | None = None,
    *,
    part: str | None = None,
    kinematics: ShellKinematics = GREEN_LAGRANGE,
) -> FlexibleBody:
    """A free body from a deck, without the deck's supports.

    interfaces : on nodes or node sets of the deck; None: one for each rigid tie and weighted mean of the deck
    part : name of a part or superelement (`named_part`); needed if there are several parts

    Raises
    ------
    MeshError, ModelError   as for `named_part`, `deck_model` and `flexible_body`
    Warns
    -----
    SuppleWarning   as for `deck_model`
    """
    own = named_part(deck, part)
    model = deck_model(own, kinematics=kinematics)
    if interfaces is None:
        interfaces = [connection_interface(each) for each in deck_connections(own)]
    return flexible_body(name, model, interfaces)


def deck_model(
    deck: Deck, *, kinematics: ShellKinematics = GREEN_LAGRANGE, held: bool = False
) -> FiniteElementModel:
    """Finite-element model of a deck with a single part: its cells, springs, masses and ties.

    held : True keeps the deck's supports, as constraints, its springs and dashpots to ground, and its scalar
        points; False omits them, as joints replace the supports in a machine

    Raises
    ------
    ModelError   a missing property, or one that a cell cannot have; unless `held`, springs that resist rigid
                 motion
    MeshError    inverted or degenerate cells; several parts
    Warns
    -----
    SuppleWarning   springs and dashpots to ground, and terms on scalar points, that are omitted; solids and
                    shells without density; material directions normal to the surface
    """
    if held:
        deck = with_scalar_points(deck)
    else:
        warn_of_scalar_points(deck, 3)
        deck = without_scalar_points(deck)
    mesh = deck_mesh(deck)
    springs, dashpots = deck.springs, deck.dashpots
    if not held:
        _warn_of_ground_springs(deck)
        springs, dashpots = ([_free(deck, terms) for terms in given] for given in (springs, dashpots))
    sections = _sections(deck)
    if bare := missing_density(deck):
        warnings.warn(f"{deck.path}: {bare}", SuppleWarning, stacklevel=3)
    turned = _has_rotations(deck) or (held and _holds_turned_nodes(deck))
    d = 6 if turned or any(section.turns_nodes() for section in sections) else 3
    attached = Attached(
        springs=linear_strains([*_spring_terms(springs, d), *_matrix_terms(deck.stiffnesses, d)], d),
        mass=_nodal_matrix(deck.masses, deck.inertias, len(deck.node_ids), d),
        damping=_nodal_matrix(deck.dampings, dashpots, len(deck.node_ids), d),
        rigid=tuple(
            RigidPiece(tie.name, np.unique(np.append(tie.nodes, tie.reference)), deck.nodes[tie.reference])
            for tie in deck.rigid
        ),
        constraints=_constraints(deck, d, (*deck.constraints, *deck.held) if held else deck.constraints),
    )
    return finite_element_model(
        mesh,
        sections,
        kinematics=kinematics,
        attached=attached,
        dofs_per_node=d,
        mass_of=CellMass.lumped if deck.lumped_mass else consistent_mass,
    )


def deck_connections(deck: Deck) -> tuple[Connection, ...]:
    """The rigid ties and weighted means of a deck as connections, for `connection_interface`."""
    rigid = (
        Connection(tie.name, np.unique(np.append(tie.nodes, tie.reference)), deck.nodes[tie.reference], None)
        for tie in deck.rigid
    )
    means = (
        Connection(mean.name, mean.nodes, deck.nodes[mean.reference], mean.weights) for mean in deck.means
    )
    return (*rigid, *means)


def missing_density(deck: Deck) -> str:
    """A sentence on solids, shells and plies without density beside other masses; "" without any.

    Decks for statics often lack densities. Bars without mass are usual as stiff connections. A body without
    any mass is refused elsewhere.
    """
    density = {name: _density(deck.properties[name]) for name in {each.property for each in deck.elements}}
    if not (deck.masses or deck.inertias or any(density.values())):
        return ""
    bare: dict[str, int] = {}
    for each in deck.elements:
        given = deck.properties[each.property]
        lacks = isinstance(given, WallProperty) and given.lacks_density
        if lacks or (each.kind.dimension > 1 and not density[each.property]):
            bare[each.property] = bare.get(each.property, 0) + len(np.unique(each.ids))
    if not bare:
        return ""
    named = ", ".join(f"{name} ({count})" for name, count in list(bare.items())[:8])
    named += f" and {len(bare) - 8} more" if len(bare) > 8 else ""
    return (
        f"{sum(bare.values())} solids or shells lack mass, because materials of these properties (number of "
        f"elements in brackets), or of their plies, have no density: {named}. Give the materials a density, "
        "unless other elements or point masses contain this mass"
    )


def refuse_omitted_cards(deck: Deck, allowed: Sequence[str] = ()) -> None:
    """Raise ModelError if the reader omitted cards that would change the body.

    allowed : names of cards that may be omitted
    """
    left = [each for each in deck.left_out if each.card not in allowed]
    if left:
        listed = "; ".join(
            f"{each.count} {each.card} (first on line {each.line}): {each.meaning}" for each in left[:8]
        )
        names = ", ".join(dict.fromkeys(f'"{each.card}"' for each in left))
        raise ModelError(
            f"{deck.path}: the file has cards that are not read and would change the body: {listed}. To omit "
            f"them: leave_out = [{names}]"
        )


def deck_mesh(deck: Deck) -> Mesh:
    """The mesh of a deck with a single part.

    Cell sets are the element sets and properties; node sets are those of the deck, rigid ties and weighted
    means. Raises MeshError for several parts, or inverted or degenerate cells.
    """
    cells: dict[CellType, list[DeckElements]] = {}
    for each in deck.elements:
        cells.setdefault(each.kind, []).append(each)
    ids = {kind: np.concatenate([each.ids for each in own]) for kind, own in cells.items()}
    sets: dict[str, dict[CellType, IntArray]] = {}
    for name, members in deck.element_sets.items():
        inside = {kind: np.flatnonzero(np.isin(numbers, members)) for kind, numbers in ids.items()}
        own = {kind: numbers for kind, numbers in inside.items() if len(numbers)}
        if own:
            sets[name] = own
    for name in dict.fromkeys(each.property for each in deck.elements):
        if name not in sets:
            sets[name] = {
                kind: np.concatenate([numbers for each, numbers in _numbered(own) if each.property == name])
                for kind, own in cells.items()
                if any(each.property == name for each in own)
            }
    node_sets = {name: np.unique(nodes) for name, nodes in deck.node_sets.items() if len(nodes)}
    node_sets |= {each.name: each.nodes for each in deck_connections(deck)}
    return Mesh(
        deck.nodes,
        {kind: np.concatenate([each.nodes for each in own]) for kind, own in cells.items()},
        node_sets,
        sets,
        deck.node_ids,
        ids,
        deck_links(deck),
    )


def _numbered(own: Sequence[DeckElements]) -> Iterator[tuple[DeckElements, IntArray]]:
    """Each group of elements of one cell type, with the cell numbers of its elements in the mesh."""
    first = 0
    for each in own:
        yield each, np.arange(first, first + len(each.ids))
        first += len(each.ids)


def _sections(deck: Deck) -> tuple[Section, ...]:
    made, first = [], dict.fromkeys(CellType, 0)
    for each in deck.elements:
        start = first[each.kind]
        first[each.kind] += len(each.ids)
        try:
            own = _property(deck.properties[each.property])
        except ModelError as error:
            raise ModelError(f"{deck.path}: {each.property}: {error}") from error
        except KeyError:
            raise ModelError(
                f"{deck.path}, line {each.lines[0]}: {each.name} {each.ids[0]} has no property "
                f"'{each.property}'; add it, or remove the element"
            ) from None
        cells = np.arange(start, first[each.kind])
        directions = _along_cells(deck, each) if each.kind.dimension == 2 else each.directions
        made.append(
            Section(
                each.kind,
                cells,
                own,
                directions,
                each.offsets,
                each.released,
                each.reduced,
                each.incompatible,
                each.mass_share,
            )
        )
    return tuple(made)


def _along_cells(deck: Deck, given: DeckElements) -> FloatArray | None:
    """Material directions (E, 3) of surface elements; None without.

    The first side of an element replaces a direction normal to its surface, with a SuppleWarning.
    """
    if given.directions is None:
        return None
    corners, towards = deck.nodes[given.nodes], np.array(given.directions)
    first = corners[:, 1] - corners[:, 0]
    normal = np.cross(first, corners[:, 2] - corners[:, 0])
    sine = np.linalg.norm(np.cross(normal, towards), axis=1)
    across = sine <= _ALONG * np.linalg.norm(normal, axis=1) * np.linalg.norm(towards, axis=1)
    if across.any():
        number = int(np.argmax(across))
        warnings.warn(
            f"{deck.path}, line {given.lines[number]}: the material direction of {given.name} "
            f"{given.ids[number]} (one of {across.sum()}) is normal to its surface; its first side is used",
            SuppleWarning,
            stacklevel=5,
        )
        towards[across] = first[across]
    return towards


def _property(
    given: Property,
) -> Isotropic | Anisotropic | HomogeneousSection | LaminateSection | BeamSection | RodSection:
    match given:
        case SolidProperty():
            material = given.material
            if isinstance(material, AnisotropicMaterial):
                return Anisotropic(material.elasticity, material.density)
            return _isotropic(material)
        case ShellProperty():
            return HomogeneousSection(
                _isotropic(given.material),
                given.thickness,
                given.offset,
                given.added_mass,
                given.shear_factor,
            )
        case WallProperty():
            return LaminateSection(
                given.membrane,
                given.coupling,
                given.bending,
                given.mass_per_area,
                given.rotary_inertia_per_area,
                shear=given.shear,
                thickness=given.thickness or None,
                mass_offset=given.mass_moment_per_area / (given.mass_per_area or 1.0),
            )
        case RodProperty():
            material, J = _of_lines(given.material), given.J if _has_shear(given.material) else 0.0
            return RodSection(material, given.area, J, given.mass_per_length, abs(given.torsion_arm))
        case BeamProperty():
            second = None if given.second is None else _beam(given.material, given.second, None)
            return _beam(given.material, given.first, second)


def _beam(material: IsotropicMaterial, values: BeamValues, second: BeamSection | None) -> BeamSection:
    shears = _has_shear(material)
    return BeamSection(
        _of_lines(material),
        values.area,
        values.I1,
        values.I2,
        values.J if shears else 0.0,
        values.K1 if shears else 0.0,
        values.K2 if shears else 0.0,
        mass_per_length=values.mass_per_length,
        I12=values.I12,
        neutral=values.neutral,
        mass_centre=values.mass_centre,
        rotary=values.rotary,
        second=second,
        geometry=values.geometry,
    )


def _isotropic(material: IsotropicMaterial) -> Isotropic:
    return Isotropic(
        material.youngs_modulus, material.poissons_ratio, material.density, material.shear_modulus
    )


def _has_shear(material: IsotropicMaterial) -> bool:
    """Whether a material resists shear; otherwise its beams and rods have no torsion or shear stiffness."""
    return material.shear_modulus is None or material.shear_modulus > 0


def _of_lines(material: IsotropicMaterial) -> Isotropic:
    """Material of beams and rods from E and G; an invalid Poisson's ratio is replaced by zero."""
    nu = material.poissons_ratio
    G = material.shear_modulus if _has_shear(material) else None
    if not -1 < nu < 0.5:
        nu, G = 0.0, G or material.youngs_modulus / (2 * (1 + nu))
    return Isotropic(material.youngs_modulus, nu, material.density, G)


def _has_rotations(deck: Deck) -> bool:
    """Whether springs, masses, constraints or means of a deck act on nodal rotations.

    A weighted mean that rotates its reference node also rotates the nodes tied rigidly to this node.
    """
    turned = [mean.reference for mean in deck.means if any(mean.components[3:])]
    if any(np.isin(turned, [*tie.nodes, tie.reference]).any() for tie in deck.rigid):
        return True
    matrices = (*deck.masses, *deck.stiffnesses)
    terms = (*deck.springs, *deck.inertias, *deck.constraints)
    return any((_rows(each)[0] % 6 > 2).any() for each in matrices) or any(
        (each.freedoms % 6 > 2)[each.factors != 0].any() for each in terms
    )


def _holds_turned_nodes(deck: Deck) -> bool:
    """Whether supports of a deck fix rotations of nodes in rigid ties, or of reference nodes that rotate.

    Nodes of solids have no rotations. A tie of them has: without these it would rotate freely on its support.
    """
    tied = [node for tie in deck.rigid for node in (*tie.nodes, tie.reference)]
    turned = [mean.reference for mean in deck.means if any(mean.components[3:])]
    fixed = [each.freedoms[(each.freedoms % 6 > 2) & (each.factors != 0)] // 6 for each in deck.held]
    return any(np.isin(nodes, [*tied, *turned]).any() for nodes in fixed)


def _rows(matrix: NodalMatrix) -> tuple[IntArray, FloatArray]:
    """The freedoms (m,) and values (m, m) of a matrix without empty rows and columns."""
    there = np.flatnonzero(matrix.values.any(axis=1) | matrix.values.any(axis=0))
    return matrix.freedoms[there], matrix.values[np.ix_(there, there)]


def _at(freedoms: IntArray, dofs_per_node: int) -> IntArray:
    """Freedom numbers of the model, from numbers 6 * node + component."""
    return freedoms // 6 * dofs_per_node + freedoms % 6


def _spring_terms(
    springs: Sequence[ScalarTerms], d: int
) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    for terms in springs:
        order = np.argsort(terms.rows, kind="stable")
        bounds = np.flatnonzero(np.diff(terms.rows[order])) + 1
        for own in np.split(order, bounds) if len(order) else ():
            k = terms.values[terms.rows[own[0]]]
            if k:
                yield _at(terms.freedoms[own], d), terms.factors[own][None], np.array([k])


def _matrix_terms(
    matrices: Sequence[NodalMatrix], d: int
) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    """Stiffness matrices as springs: freedoms, eigenvectors as rows, and nonzero eigenvalues of each."""
    for matrix in matrices:
        freedoms, values = _rows(matrix)
        if not len(freedoms):
            continue
        stiffness, vectors = np.linalg.eigh(values)
        counts = np.abs(stiffness) > 1e-14 * np.abs(stiffness).max()
        yield _at(freedoms, d), vectors.T[counts], stiffness[counts]


def _nodal_matrix(
    matrices: Sequence[NodalMatrix], scalars: Sequence[ScalarTerms], n_nodes: int, d: int
) -> sparse.csc_array | None:
    """Sum (n, n) of matrices between freedoms and of scalar terms; None if all entries are zero."""
    rows, columns, values = [], [], []
    for matrix in matrices:
        freedoms, own = _rows(matrix)
        there = np.flatnonzero(freedoms % 6 < d)  # no rotations if nodes have none, as in `_matrix`
        at, own = _at(freedoms[there], d), own[np.ix_(there, there)]
        rows.append(np.repeat(at, len(at)))
        columns.append(np.tile(at, len(at)))
        values.append(own.ravel())
    for terms in scalars:
        if not len(terms.rows):
            continue
        B = _matrix(terms, n_nodes, d)
        added = sparse.coo_array(B.T @ sparse.diags_array(terms.values) @ B)
        rows.append(added.coords[0])
        columns.append(added.coords[1])
        values.append(added.data)
    if not any(np.any(each) for each in values):
        return None
    places = np.concatenate(rows), np.concatenate(columns)
    return sparse.csc_array(sparse.coo_array((np.concatenate(values), places), shape=(n_nodes * d,) * 2))


def _matrix(terms: ScalarTerms, n_nodes: int, d: int) -> sparse.csr_array:
    """Factors (m, n) of m linear combinations over n nodal freedoms; no rotations if nodes have none."""
    there = terms.freedoms % 6 < d
    places = terms.rows[there], _at(terms.freedoms[there], d)
    return sparse.csr_array(
        sparse.coo_array((terms.factors[there], places), shape=(len(terms.lines), n_nodes * d))
    )


def _constraints(deck: Deck, d: int, given: Sequence[ScalarTerms]) -> Constraints | None:
    """Constraints of `given`, and those by which reference nodes follow weighted means; None if none."""
    parts = [_zero_sums(deck, terms, d) for terms in given if len(terms.lines)]
    parts += [_following(deck, mean, d) for mean in deck.means]
    if not parts:
        return None
    return Constraints(
        sparse.csr_array(sparse.vstack([each.matrix for each in parts])),
        np.concatenate([each.dependent for each in parts]),
        tuple(label for each in parts for label in each.labels),
    )


def _zero_sums(deck: Deck, terms: ScalarTerms, d: int) -> Constraints:
    """Constraints that set linear combinations to zero."""
    dependent = np.full(len(terms.lines), -1)
    if len(terms.dependent):
        dependent = np.where(terms.dependent >= 0, _at(np.maximum(terms.dependent, 0), d), -1)
    labels = tuple(f"{deck.path}, line {line}: the constraint" for line in terms.lines)
    return Constraints(_matrix(terms, len(deck.node_ids), d), dependent, labels)


def _following(deck: Deck, mean: WeightedMean, d: int) -> Constraints:
    """Constraints u_ref - (mean motion of the nodes) = 0, for the components that follow."""
    used = np.flatnonzero(mean.weights > 0)
    nodes = mean.nodes[used]
    motion = averaged_motion(deck.nodes[nodes], mean.weights[used], deck.nodes[mean.reference], d)
    rows = np.flatnonzero(mean.components[:d])
    own = (nodes[:, None] * d + np.arange(d)).ravel()
    values = -motion.reshape(6, -1)[rows]
    i, j = np.nonzero(values)
    dependent = mean.reference * d + rows
    places = np.concatenate([i, np.arange(len(rows))]), np.concatenate([own[j], dependent])
    entries = np.concatenate([values[i, j], np.ones(len(rows))])
    shape = (len(rows), len(deck.node_ids) * d)
    labels = (f"{deck.path}, line {mean.line}: {mean.name}",) * len(rows)
    return Constraints(sparse.csr_array(sparse.coo_array((entries, places), shape=shape)), dependent, labels)


def _ground(terms: ScalarTerms) -> NDArray[np.bool_]:
    """Mask of the linear combinations on a single node, which are springs or dashpots to ground."""
    nodes = np.unique(np.column_stack([terms.rows, terms.freedoms // 6]), axis=0)
    return np.bincount(nodes[:, 0], minlength=len(terms.lines)) == 1


def _free(deck: Deck, terms: ScalarTerms) -> ScalarTerms:
    """Springs or dashpots without those to ground; ModelError if one resists rigid motion."""
    kept = ~_ground(terms)[terms.rows] if len(terms.rows) else np.empty(0, dtype=bool)
    own = ScalarTerms(terms.rows[kept], terms.freedoms[kept], terms.factors[kept], terms.lines, terms.values)
    rows = _matrix(own, len(deck.node_ids), 6)
    R = nodal_rigid_modes(deck.nodes - deck.nodes.mean(axis=0), 6)
    R[:, 3:] /= max(float(np.ptp(deck.nodes, axis=0).max()), np.finfo(float).tiny)
    moved, whole = np.abs(rows @ R), abs(rows) @ np.abs(R)
    bad = np.flatnonzero((moved > _RIGID * np.maximum(whole, np.finfo(float).tiny)).any(axis=1))
    bad = bad[terms.values[bad] != 0]
    if bad.size:
        raise ModelError(
            f"{deck.path}, line {terms.lines[bad[0]]}: a spring or dashpot (one of {bad.size}) resists "
            "rigid motion of its body: it acts across the line between its nodes. Let it act along the "
            "line between its nodes, or make both nodes coincide"
        )
    return own


def _density(given: Property) -> float:
    """Mass per volume, area or length of a property; zero if its cells have no mass."""
    match given:
        case SolidProperty():
            return given.material.density
        case ShellProperty():
            return given.material.density + given.added_mass
        case WallProperty():
            return given.mass_per_area
        case RodProperty():
            return given.mass_per_length
        case BeamProperty():
            return max(each.mass_per_length for each in (given.first, given.second) if each is not None)


def _warn_of_ground_springs(deck: Deck) -> None:
    ground = [int(line) for terms in (*deck.springs, *deck.dashpots) for line in terms.lines[_ground(terms)]]
    if ground:
        warnings.warn(
            f"{deck.path}: {len(ground)} springs or dashpots to ground, first on line "
            f"{min(ground)}, are supports, which a free body omits: add joints and springs to the machine",
            SuppleWarning,
            stacklevel=4,
        )

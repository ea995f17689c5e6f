"""Springs, dampers and masses of a Nastran deck: CELAS, CBUSH, CDAMP, CVISC, CMASS, CONM, CSHEAR."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from supple.arrays import FloatArray, IntArray
from supple.importers.deck import NodalMatrix
from supple.importers.freedom_sums import Terms, motion_along
from supple.importers.nastran.bulk_data import BulkCard, by_id
from supple.importers.nastran.cells import grids_named
from supple.importers.nastran.deck_reading import DeckReading, times
from supple.importers.nastran.materials import Materials

POINT_CARDS = (
    "CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CMASS1", "CMASS2",
    "CMASS3", "CMASS4", "CBUSH", "CBUSH1D", "CVISC", "CONM1", "CONM2", "CSHEAR",
)  # fmt: skip
POINT_PROPERTY_CARDS = ("PELAS", "PDAMP", "PMASS", "PBUSH", "PBUSH1D", "PVISC", "PSHEAR")

# Number of fields of one property; a card may define several properties.
_PER_PROPERTY = {"PELAS": 4, "PDAMP": 2, "PMASS": 2, "PVISC": 4}


Known = TypeVar("Known", BulkCard, tuple[BulkCard, int])


def read_point_elements(reading: DeckReading, materials: Materials) -> None:
    """Add every spring, damper and mass of the file to the reading."""
    scalars = {name: _several(reading.file.named(name), step) for name, step in _PER_PROPERTY.items()}
    for kind, of, rows, factor in (
        ("CELAS", "PELAS", reading.springs, reading.stiffness_factor),
        ("CDAMP", "PDAMP", reading.dashpots, reading.damping_factor),
        ("CMASS", "PMASS", reading.inertias, reading.mass_factor),
    ):
        for form in "1234":
            for card in reading.file.named(f"{kind}{form}"):
                value, terms = _scalar(card, form, scalars[of], of, reading)
                if value and terms:
                    rows.add(terms, card.line, value=value * factor)
    for card in reading.file.named("CVISC"):
        _viscous(card, scalars["PVISC"], reading)
    for name, of, read in (("CBUSH", "PBUSH", _bush), ("CBUSH1D", "PBUSH1D", _bush_along)):
        properties = by_id(reading.file.named(of), "property")
        for card in reading.file.named(name):
            known = _property(card, properties, of, reading)
            if known is not None:
                read(card, known, reading)
    panels = by_id(reading.file.named("PSHEAR"), "property")
    for card in reading.file.named("CSHEAR"):
        _shear_panel(card, panels.get(card.property_id()), materials, reading)
    reading.masses += [_conm2(card, reading) for card in reading.file.named("CONM2")]
    reading.masses += [_conm1(card, reading) for card in reading.file.named("CONM1")]


def _several(cards: list[BulkCard], step: int) -> dict[int, tuple[BulkCard, int]]:
    """Properties by id: the card and the index of the first field; errors as for `by_id`."""
    found = [(card, i) for card in cards for i in range(0, len(card.fields), step) if card.word(i)]
    by_id([card._replace(fields=card.fields[i : i + step]) for card, i in found], "property")
    return {card.integer(i, "the property id"): (card, i) for card, i in found}


def _property(card: BulkCard, properties: dict[int, Known], of: str, reading: DeckReading) -> Known | None:
    """The property of an element; None if it is missing, with a record."""
    found = properties.get(card.property_id())
    if found is None:
        reading.leave_out(card, f"elements left out: no {of} is their property")
    return found


def _scalar(
    card: BulkCard, form: str, properties: dict[int, tuple[BulkCard, int]], of: str, reading: DeckReading
) -> tuple[float, Terms]:
    """EID, then property (forms 1, 3) or value (2, 4), then G1 C1 G2 C2 (1, 2) or S1 S2 (3, 4).

    A blank point is ground. Returns the value and the terms between the points.
    """
    if form in "13":
        found = _property(card, properties, of, reading)
        if found is None:
            return 0.0, []
        known, place = found
        value = known.real(place + 1, "its value", 0.0)
    else:
        value = card.real(1, "its value", 0.0)
    pairs = ((2, 3), (4, 5)) if form in "12" else ((2, None), (3, None))
    terms: Terms = []
    for sign, (point, component) in zip((1.0, -1.0), pairs, strict=True):
        if card.word(point) not in ("", "0"):
            number = card.integer(point, "a point")
            direction = 1 if component is None else card.integer(component, "a component", 0)
            terms += times(reading.freedom(card, number, direction), sign)
    return value, terms


# --- springs between two grids in axes of their own


def _relative(
    a: int, b: int | None, axes: FloatArray, at: FloatArray, place: int, reading: DeckReading
) -> Terms:
    """Terms of component `place` (0 to 5) of the motion of b relative to a at the point `at`, in given axes.

    b : None is ground;  axes : (3, 3) as columns
    """
    terms: Terms = []
    for node, sign in ((a, -1.0), (b, 1.0)):
        if node is not None:
            arm = at - reading.grids.positions[node]
            e, turns = axes[:, place % 3], place > 2
            terms += motion_along(node, e, sign, arm=None if turns else arm, rotation=turns)
    return terms


def _ends(card: BulkCard, reading: DeckReading) -> tuple[int, int | None, FloatArray, FloatArray]:
    """Grids GA and GB, and their positions; without GB, which is then ground, twice the position of GA."""
    a = reading.node(card, 2, "the grid GA")
    b = reading.node(card, 3, "the grid GB") if card.word(3) not in ("", "0") else None
    return a, b, reading.grids.positions[a], reading.grids.positions[a if b is None else b]


def _bush(card: BulkCard, known: BulkCard, reading: DeckReading) -> None:
    """EID PID GA GB X1 X2 X3/G0 CID S OCID S1 S2 S3: springs and dampers at a point between two grids."""
    a, b, xa, xb = _ends(card, reading)
    axes = _bush_axes(card, a, xa, xb, reading)
    if card.word(9) in ("", "-1"):
        at = xa + card.real(8, "S", 0.5) * (xb - xa)
    else:
        given = card.reals(10, "S1", "S2", "S3")
        at = reading.system(card, card.integer(9, "OCID")).basic(given)
    rows = {
        "K": (reading.springs, reading.stiffness_factor),
        "B": (reading.dashpots, reading.damping_factor),
    }
    for kind, values in _bush_values(known).items():
        if kind == "M":
            _bush_mass(a, b, values[0], reading)
        elif kind == "RIGID":
            reading.leave_out(
                known, "rigid directions of a CBUSH (K = RIGID) are not read: they have no stiffness"
            )
        elif kind == "MISPLACED":
            reading.leave_out(known, "a line without its K, B or M in the third field is not read")
        elif kind in rows:
            collected, factor = rows[kind]
            for place, value in enumerate(values[:6]):
                if value:
                    terms = _relative(a, b, axes, at, place, reading)
                    collected.add(terms, card.line, value=value * factor)


def _bush_values(known: BulkCard) -> dict[str, list[float]]:
    """Six values of each group K, B, M of a PBUSH.

    A value RIGID counts as zero, and the key "RIGID" is added; "MISPLACED" for a line that starts with a word
    in the second field.
    """
    found: dict[str, list[float]] = {}
    for start in range(0, len(known.fields), 8):
        kind = known.word(start + 1)
        if start and known.word(start):
            found["MISPLACED"] = []
        elif kind in ("K", "B", "M") or (not start and kind):
            rigid = [known.word(start + 2 + i) == "RIGID" for i in range(6)]
            if any(rigid):
                found["RIGID"] = []
            found[kind] = [
                0.0 if rigid[i] else known.real(start + 2 + i, f"{kind}{i + 1}", 0.0) for i in range(6)
            ]
    return found


def _bush_mass(a: int, b: int | None, mass: float, reading: DeckReading) -> None:
    ends = [a] if b is None else [a, b]
    for node in ends:
        share = mass * reading.mass_factor / len(ends)
        reading.masses.append(NodalMatrix(6 * node + np.arange(3), share * np.eye(3)))


def _bush_axes(card: BulkCard, a: int, xa: FloatArray, xb: FloatArray, reading: DeckReading) -> FloatArray:
    """Axes of CID at GA; without CID, x from GA to GB and y in the plane of the vector.

    Basic axes without CID if GA and GB coincide, or GB is ground.
    """
    if card.word(7):
        return reading.system(card, card.integer(7, "CID")).directions(xa[None])[0]
    chord, vector = xb - xa, reading.vector(card, a, xa)
    length = np.linalg.norm(chord)
    if not length > 0:
        return np.identity(3)
    x = chord / length
    z = np.cross(x, vector)
    if not np.linalg.norm(z) > 1e-6 * max(float(np.linalg.norm(vector)), 1e-300):
        # Only the spring along the line is defined; any lateral directions will do.
        z = np.cross(x, np.eye(3)[np.argmin(np.abs(x))])
    z /= np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=1).astype(np.float64)


def _bush_along(card: BulkCard, known: BulkCard, reading: DeckReading) -> None:
    """EID PID GA GB CID; PBUSH1D: K C M: a spring and damper along GA-GB or x of CID, and a mass."""
    a, b, xa, xb = _ends(card, reading)
    if card.word(4):
        axes = reading.system(card, card.integer(4, "CID")).directions(xa[None])[0]
    else:
        axes = _along(card, xa, xb, "give CID")
    terms = _relative(a, b, axes, xa, 0, reading)
    k, c, m = known.reals(1, "K", "C", "M")
    if any(known.word(place) for place in range(8, len(known.fields))):
        reading.leave_out(known, "values that depend on displacement or speed are not read; K and C are")
    if k:
        reading.springs.add(terms, card.line, value=k * reading.stiffness_factor)
    if c:
        reading.dashpots.add(terms, card.line, value=c * reading.damping_factor)
    if m:
        _bush_mass(a, b, m, reading)


def _along(card: BulkCard, xa: FloatArray, xb: FloatArray, remedy: str) -> FloatArray:
    """The direction (3, 3) from GA to GB, in each column."""
    length = np.linalg.norm(xb - xa)
    if not length > 0:
        raise card.error(f"its two grids coincide, so it has no direction; {remedy}")
    return np.repeat(((xb - xa) / length)[:, None], 3, axis=1)


def _viscous(card: BulkCard, properties: dict[int, tuple[BulkCard, int]], reading: DeckReading) -> None:
    """EID PID G1 G2; PVISC: CE along the line, CR about it."""
    found = _property(card, properties, "PVISC", reading)
    if found is None:
        return
    known, place = found
    a, b = (reading.node(card, 2 + i, "a grid") for i in range(2))
    xa = reading.grids.positions[a]
    axes = _along(card, xa, reading.grids.positions[b], "use CDAMP")
    for which, of in ((0, 1), (3, 2)):
        value = known.real(place + of, "its damping", 0.0) * reading.damping_factor
        if value:
            reading.dashpots.add(_relative(a, b, axes, xa, which, reading), card.line, value=value)


# --- masses


def _conm2(card: BulkCard, reading: DeckReading) -> NodalMatrix:
    """EID G CID M X1 X2 X3 - I11 I21 I22 I31 I32 I33: a rigid mass, moments I about its centre of mass.

    About the grid, with offset d and cross-product matrix [d]x:  [m, -m [d]x; m [d]x, I - m [d]x [d]x];
    the off-diagonal entries of I are -I21, -I31, -I32.
    CID = -1: X1 X2 X3 is the position of the centre of mass in basic coordinates.
    """
    node = reading.node(card, 1, "the grid G")
    m = card.real(3, "M", 0.0)
    offset = np.array(card.reals(4, "X1", "X2", "X3"))
    I11, I21, I22, I31, I32, I33 = card.reals(8, "I11", "I21", "I22", "I31", "I32", "I33")
    inertia = np.array([[I11, -I21, -I31], [-I21, I22, -I32], [-I31, -I32, I33]])
    system = card.integer(2, "CID", 0)
    at = reading.grids.positions[node]
    if system == -1:
        offset = offset - at
    else:
        axes = reading.system(card, system).directions(at[None])[0]
        offset, inertia = axes @ offset, axes @ inertia @ axes.T
    x = np.array([[0.0, -offset[2], offset[1]], [offset[2], 0.0, -offset[0]], [-offset[1], offset[0], 0.0]])
    M = np.block([[m * np.eye(3), -m * x], [m * x, inertia - m * x @ x]])
    return _kept(6 * node + np.arange(6), M * reading.mass_factor)


def _conm1(card: BulkCard, reading: DeckReading) -> NodalMatrix:
    """EID G CID M11 M21 M22 M31 .. M66: a symmetric matrix in the axes of CID."""
    node = reading.node(card, 1, "the grid G")
    M = np.zeros((6, 6))
    M[np.tril_indices(6)] = card.reals(3, *["an entry"] * 21)
    M = M + np.tril(M, -1).T
    at = reading.grids.positions[node]
    axes = np.kron(np.eye(2), reading.system(card, card.integer(2, "CID", 0)).directions(at[None])[0])
    return _kept(6 * node + np.arange(6), axes @ M @ axes.T * reading.mass_factor)


def _kept(freedoms: IntArray, M: FloatArray) -> NodalMatrix:
    """The matrix without zero rows of rotations, so that a mass without inertia needs no rotations."""
    used = np.abs(M).max(axis=1) > 0
    used[:3] = True
    return NodalMatrix(freedoms[used], M[np.ix_(used, used)])


# --- shear panels


def _shear_panel(card: BulkCard, known: BulkCard | None, materials: Materials, reading: DeckReading) -> None:
    """EID PID G1 G2 G3 G4; PSHEAR: MID T NSM F1 F2: a panel with a constant shear flow only.

    A unit shear flow along the four sides, as forces at the ends of each side, does the work
    w = sum of -+ L/2 (u_i + u_j) . t_ij,  where the side ij has length L and direction t_ij. The panel is a
    spring with elongation w and stiffness 1 / c. Its compliance is  c = A / (G t) (1 + 2 tan^2 a / (1 + nu)),
    with area A and thickness t; 90 degrees - a is the angle between the two lines that join the midpoints of
    opposite sides. The mass is lumped to the four grids.
    Source: MacNeal, The NASTRAN Theoretical Manual (1972), section 5.3, after Garvey.
    """
    material = None if known is None else materials.isotropic(known.integer(1, "the material id"))
    if known is None or isinstance(material, str) or material is None:
        reading.leave_out(card, "elements left out: their property or material is not supported")
        return
    t, nsm, F1, F2 = known.reals(2, "T", "NSM", "F1", "F2")
    if F1 or F2:
        reading.leave_out(known, "the extensional stiffness F1, F2 of a shear panel's edges is not read")
    nodes = grids_named([card], reading, 2, 4)[0]
    x = reading.grids.positions[nodes]
    area = float(np.linalg.norm(np.cross(x[2] - x[0], x[3] - x[1])) / 2)
    E, nu = material.youngs_modulus, material.poissons_ratio
    G = E / (2 * (1 + nu)) if material.shear_modulus is None else material.shear_modulus
    if not (area > 0 and t > 0 and G > 0):
        raise card.error("its area, thickness or shear modulus is zero; correct it")
    across, along = x[2] + x[3] - x[0] - x[1], x[1] + x[2] - x[0] - x[3]
    lean = float(across @ along / np.linalg.norm(np.cross(across, along)))
    terms: Terms = []
    for i, sign in enumerate((-1.0, 1.0, -1.0, 1.0)):
        j = (i + 1) % 4
        side = sign * (x[j] - x[i]) / 2
        terms += [(6 * int(node) + k, float(side[k])) for node in (nodes[i], nodes[j]) for k in range(3)]
    compliance = area / (G * t) * (1 + 2 * lean**2 / (1 + nu))
    reading.springs.add(terms, card.line, value=1 / compliance)
    mass = (material.density * t + nsm * reading.mass_factor) * area / 4
    if mass:
        for node in nodes.tolist():
            reading.masses.append(NodalMatrix(6 * node + np.arange(3), mass * np.eye(3)))
    reading.note(
        "Shear panels (CSHEAR) are one spring each, with the stiffness of a constant shear flow; their mass "
        "is lumped to their grids."
    )

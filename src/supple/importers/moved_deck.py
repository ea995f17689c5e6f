"""A deck moved, rotated or mirrored, with all positions, directions, freedoms and sections."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from supple.arrays import FloatArray, IntArray
from supple.importers.deck import (
    AnisotropicMaterial,
    BeamProperty,
    BeamValues,
    Deck,
    DeckElements,
    LeftOut,
    NodalMatrix,
    Property,
    ScalarTerms,
    SolidProperty,
    WallProperty,
    WeightedMean,
)
from supple.mesh.reference_cell import mirrored_order

# Largest absolute value of a component that is treated as zero.
_NONE = 1e-14


def moved_deck(deck: Deck, Q: FloatArray, shift: FloatArray) -> Deck:
    """The deck with x -> Q x + shift.

    Displacements u become Q u; rotations theta are axial vectors and become det(Q) Q theta. The node order of
    a mirrored cell is reversed, so that its normal is the mirrored normal. The second axis of a wall and of a
    beam is then opposite to the mirrored axis, and stiffness terms that are odd in this axis change sign.
    Anisotropic solids in basic axes get `directions`. A weighted mean that only some components follow is
    left out if its axes are rotated.

    Parameters
    ----------
    Q : (3, 3) orthogonal, det +1 or -1 (mirrored);  shift : (3,)
    """
    turn = _ChangedAxes(np.asarray(Q, dtype=np.float64), 6 * len(deck.node_ids))
    kept = tuple(mean for mean in deck.means if turn.keeps(mean.components))
    lost = [mean for mean in deck.means if not turn.keeps(mean.components)]
    left = [
        LeftOut(
            mean.name, 1, mean.line, "it has only some components, in axes that are rotated with its part"
        )
        for mean in lost
    ]
    return replace(
        deck.with_actions(turn.matrix, turn.terms),
        nodes=deck.nodes @ turn.Q.T + shift,
        elements=tuple(turn.elements(each, deck.properties[each.property]) for each in deck.elements),
        properties={name: turn.property(each) for name, each in deck.properties.items()},
        means=tuple(replace(mean, components=turn.components(mean)) for mean in kept),
        left_out=(*deck.left_out, *left),
    )


@dataclass(frozen=True, eq=False)
class _ChangedAxes:
    """A rotation or reflection Q of n_freedoms freedoms of nodes; scalar points follow them, unchanged."""

    Q: FloatArray
    n_freedoms: int

    @property
    def mirrors(self) -> bool:
        """Whether the axes are mirrored."""
        return bool(np.linalg.det(self.Q) < 0)

    @property
    def whole(self) -> FloatArray:
        """Transformation (6, 6) of the six freedoms of a node."""
        axial = -self.Q if self.mirrors else self.Q
        return np.block([[self.Q, np.zeros((3, 3))], [np.zeros((3, 3)), axial]])

    def expansion(self, freedoms: IntArray) -> sparse.csr_array:
        """Rows (k, n) that express freedoms by the new ones: u_j = sum_i whole_ij u'_i."""
        n = int(max(self.n_freedoms, freedoms.max(initial=-1) + 1))
        placed = freedoms < self.n_freedoms
        factors = np.where(placed[:, None], self.whole.T[freedoms % 6], np.eye(6)[freedoms % 6])
        row, component = np.nonzero(np.abs(factors) > _NONE)
        places = row, 6 * (freedoms[row] // 6) + component
        return sparse.csr_array(sparse.coo_array((factors[row, component], places), shape=(len(freedoms), n)))

    def terms(self, given: ScalarTerms) -> ScalarTerms:
        """Terms in the new axes."""
        shape = (len(given.lines), len(given.freedoms))
        order = np.arange(len(given.freedoms))
        sums = sparse.coo_array((given.factors, (given.rows, order)), shape=shape)
        made = sparse.coo_array(sparse.csr_array(sums) @ self.expansion(given.freedoms))
        rows, freedoms = (np.asarray(each, dtype=np.int64) for each in made.coords)
        there = np.abs(made.data) > _NONE * np.abs(given.factors).max(initial=0.0)
        return replace(
            given,
            rows=rows[there],
            freedoms=freedoms[there],
            factors=made.data[there],
            dependent=self.dependent(given.dependent),
        )

    def dependent(self, given: IntArray) -> IntArray:
        """The freedom that each row eliminates if it is a single freedom in the new axes, too; else -1."""
        own = np.maximum(given, 0)
        factors = np.abs(self.whole.T[own % 6])
        new = 6 * (own // 6) + factors.argmax(axis=1)
        same = (given >= 0) & (factors.max(axis=1) > 1 - _NONE) & (own < self.n_freedoms)
        return np.where(same, new, np.where(given >= self.n_freedoms, given, -1))

    def matrix(self, given: NodalMatrix) -> NodalMatrix:
        """A matrix in the new axes."""
        whole = self.expansion(given.freedoms)
        used = np.unique(whole.indices).astype(np.int64)
        own = whole[:, used].toarray()
        return NodalMatrix(used, own.T @ given.values @ own)

    def elements(self, given: DeckElements, made_of: Property) -> DeckElements:
        """Cells, their directions and offsets in the new axes."""
        directions, offsets = given.directions, given.offsets
        if directions is None and isinstance(made_of, SolidProperty):
            if isinstance(made_of.material, AnisotropicMaterial):
                directions = np.tile(self.Q, (len(given.nodes), 1, 1))
        elif directions is not None:
            directions = self.Q @ directions if directions.ndim == 3 else directions @ self.Q.T
        return replace(
            given,
            nodes=given.nodes[:, mirrored_order(given.kind)] if self.mirrors else given.nodes,
            directions=directions,
            offsets=None if offsets is None else offsets @ self.Q.T,
        )

    def property(self, given: Property) -> Property:
        """A property; for mirrored axes terms that are odd in the second axis change sign."""
        if not self.mirrors:
            return given
        if isinstance(given, WallProperty):
            odd = np.diag([1.0, 1.0, -1.0])
            A, B, D = (odd @ each @ odd for each in (given.membrane, given.coupling, given.bending))
            side = np.diag([1.0, -1.0])
            shear = None if given.shear is None else side @ given.shear @ side
            return replace(given, membrane=A, coupling=B, bending=D, shear=shear)
        if isinstance(given, BeamProperty):
            second = None if given.second is None else _mirrored_beam(given.second)
            return replace(given, first=_mirrored_beam(given.first), second=second)
        return given

    def keeps(self, components: tuple[bool, ...]) -> bool:
        """Whether the selected components of a node are also components in the new axes."""
        halves = (components[:3], components[3:])
        return all(len(set(half)) == 1 for half in halves) or bool(
            (np.abs(self.Q).max(axis=0) > 1 - _NONE).all()
        )

    def components(self, mean: WeightedMean) -> tuple[bool, ...]:
        """Components of a weighted mean in the new axes."""
        given = np.array(mean.components)
        if all(len(set(half)) == 1 for half in (mean.components[:3], mean.components[3:])):
            return mean.components
        return tuple((np.rint(np.abs(self.whole)) @ given > 0).tolist())


def _mirrored_beam(given: BeamValues) -> BeamValues:
    """The mirrored section; its z axis, normal to plane 1, is opposite to the mirrored z axis."""
    (y, z), (own_y, own_z) = given.neutral, given.mass_centre
    geometry = None if given.geometry is None else given.geometry.mirrored()
    return replace(given, I12=-given.I12, neutral=(y, -z), mass_centre=(own_y, -own_z), geometry=geometry)

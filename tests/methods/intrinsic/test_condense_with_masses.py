"""Lines of bodies with concentrated masses, springs and ties, which hang on their stations."""

from __future__ import annotations

import numpy as np
import pytest

from supple.algebra import lowest_modes
from supple.body import RigidInterface, deck_model, flexible_body
from supple.body.rigid_motion import nodal_rigid_modes
from supple.errors import ModelError
from supple.importers import read_deck
from supple.methods.intrinsic import FREE, LoadPath, condense

N = 20
BEAM = "\n".join(
    [
        *(f"GRID,{i + 1},,{i / N},0.,0." for i in range(N + 1)),
        *(f"CBAR,{i + 1},7,{i + 1},{i + 2},0.,0.,1." for i in range(N)),
        "PBAR,7,5,4.-4,1.3-8,1.3-8,2.-8",
        "MAT1,5,2.1+11,,.3,7850.",
        "PARAM,COUPMASS,1",
        "",
    ]
)
# An offset mass with inertia, a mass on a rigid arm, and a mass on a spring in one place with its grid.
BESIDE = """\
CONM2,31,21,,1.,.05,.1,0.
,.01,0.,.02,0.,0.,.03
GRID,41,,.5,.2,.1
RBE2,42,11,123456,41
CONM2,43,41,,2.
"""


@pytest.fixture
def body(tmp_path):
    """The beam with further cards."""

    def made(cards):
        path = tmp_path / "beam.bdf"
        path.write_text(BEAM + cards)
        model = deck_model(read_deck(path))
        return flexible_body("beam", model, [RigidInterface("root", [0]), RigidInterface("tip", [N])])

    return made


def test_concentrated_masses_hang_on_the_stations(body):
    beam = body(BESIDE)
    line = condense(beam, LoadPath("root", "tip", 11), support=FREE, n_modes=4).line
    R = nodal_rigid_modes(beam.nodes - line.tree.points[0], 6)
    exact = R.T @ (beam.nodal_mass @ R)
    assert line.total_mass == pytest.approx(3.0 + 7850 * 4e-4, rel=1e-12)
    assert line.twists.T @ line.mass @ line.twists == pytest.approx(exact, abs=1e-12 * exact.max())


def test_frequencies_with_masses_ties_and_springs_are_those_of_the_body(body):
    beam = body(
        BESIDE + "CELAS2,51,2.+3,6,3,61,3\nGRID,61,,.25,0.,0.\nCONM2,62,61,,.02\nCELAS2,63,1.+6,6,1,61,1\n"
        "CELAS2,64,1.+6,6,2,61,2\n"
    )
    root = beam.interface("root").motion.toarray()
    exact = np.sqrt(lowest_modes(beam.stiffness, beam.mass, 5, constraint=root).values)
    found = condense(beam, LoadPath("root", "tip", N + 1), n_modes=12).modes.omega[:5]
    # The line sets the spring's mass, 0.02 kg, rigidly on its station: frequencies below that of it, 50 Hz.
    np.testing.assert_allclose(found[:3], exact[:3], rtol=2e-3)


@pytest.mark.parametrize(
    ("cards", "message"),
    [
        ("CMASS2,31,1.,3,1,9,1\n", "2 terms of concentrated masses act between nodes"),
        ("CDAMP2,31,1.,3,1,9,1\n", "the line of body 'beam' supports no dashpots beside its elements"),
    ],
)
def test_what_a_line_has_no_place_for_is_refused(body, cards, message):
    with pytest.raises(ModelError, match=message):
        condense(body(cards), LoadPath("root", "tip", 11))

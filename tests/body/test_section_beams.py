"""Chains of coupled beams beside lines of the same table and an independent integration."""

import numpy as np
import pytest
from fixtures.section_tables import COUPLED, OFFSET, helix, helix_table, prismatic

from supple.body import RigidInterface, flexible_body, section_beams
from supple.errors import ModelError
from supple.methods.intrinsic import section_line
from supple_benchmarks.references.section_beam import SectionAt, clamped_frequencies, clamped_rest

L = 4.0


def test_a_prismatic_chain_has_the_stiffness_of_the_line():
    model, line = section_beams(prismatic(L), 4), section_line("beam", prismatic(L), 5)
    assert model.stiffness.toarray() == pytest.approx(line.stiffness, abs=1e-8 * line.stiffness.max())
    rigid = line.twists
    assert rigid.T @ model.mass @ rigid == pytest.approx(rigid.T @ line.mass @ rigid, abs=1e-9)


def held_frequencies(model, number):
    body = flexible_body("beam", model, [RigidInterface("root", "root")])
    rows = body.interface("root").motion.toarray()
    return np.sqrt(body.lowest_modes(number, rows).values)


def test_frequencies_converge_to_those_of_the_beam():
    exact = clamped_frequencies(
        lambda _s: SectionAt(np.eye(3), COUPLED, OFFSET), np.linspace(0, L, 41), np.linspace(5.0, 420.0, 84)
    )[:4]
    errors = [held_frequencies(section_beams(prismatic(L), n), 4) / exact - 1 for n in (10, 20)]
    assert np.abs(errors[1]).max() < 2e-2
    assert (np.abs(errors[0]) / np.abs(errors[1]) > 3.0).all()


def test_a_curved_twisted_tapering_chain():
    def section(s):
        return helix(s)[1]

    steps, gravity = np.linspace(0, L, 81), np.array([0.4, -1.0, -9.0])
    rest, exact = (
        clamped_rest(section, steps, gravity),
        clamped_frequencies(section, steps, np.linspace(5.0, 200.0, 66))[:3],
    )
    model = section_beams(helix_table(41))
    weight = model.mass @ np.tile(np.append(gravity, np.zeros(3)), 41)
    tip = np.linalg.solve(model.stiffness.toarray()[6:, 6:], weight[6:])[-6:]
    assert tip == pytest.approx(rest[:6], abs=3e-3 * np.abs(rest[:6]).max())
    assert held_frequencies(model, 3) == pytest.approx(exact, rel=3e-3)


def test_no_element_is_refused():
    with pytest.raises(ModelError, match="needs at least one element, not 0"):
        section_beams(prismatic(), 0)

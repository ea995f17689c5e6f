"""Nodes without mass follow the others statically: forces on them are warned of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import AveragingInterface, FullBody, MeanAxisFrame, deck_model, flexible_body
from supple.cases import read_case
from supple.errors import BasisWarning
from supple.importers import read_deck
from supple.machine import DeadForce, System
from supple.reduction import NoDerivatives, NoLoads, Rubin, reduce

# A cantilever without density and with masses at its ends; the node between has none.
DECK = """GRID,11,,0.,0.,0.
GRID,12,,1.,0.,0.
GRID,13,,2.,0.,0.
CBAR,1,7,11,12,0.,0.,1.
CBAR,2,7,12,13,0.,0.,1.
PBAR,7,5,4.-4,1.3-8,1.3-8,2.-8
MAT1,5,2.1+11,,.3
CONM2,21,11,,5.
,.1,,.1,,,.1
CONM2,22,13,,5.
,.1,,.1,,,.1
SPC1,1,3,12
SPC1,2,3,13
"""
CASE = """title = "a stick model"
[[body]]
name = "arm"
mesh = "beam.bdf"
nastran = {{}}
linear = true
frame = {{ kind = "nodal-fixed", interface = "root" }}
reduction = {{ basis = "craig-bampton", modes = 4 }}
interface = [{{ name = "root", node_indices = [11] }}]
[[load]]
kind = "force"
at = "arm.{}"
vector = [0.0, 0.0, 10.0]
[simulation]
duration = 0.1
output_step = 0.1
step = 0.01
"""


def test_a_force_on_a_node_without_mass_is_warned_of(tmp_path):
    (tmp_path / "beam.bdf").write_text(DECK)
    (tmp_path / "case.toml").write_text(CASE.format("spc1_3"))
    case = read_case(tmp_path / "case.toml")
    assert case.flexible["arm"].massless.tolist() == [1]
    with pytest.warns(BasisWarning, match=r"on 1 nodes of 'arm': node 12 \(one of 1\) has no mass"):
        assert len(case.system.loads) == 1
    (tmp_path / "beam.bdf").write_text(DECK.replace("11,,.3", "11,,.3,7850."))
    assert len(read_case(tmp_path / "case.toml").system.loads) == 1
    (tmp_path / "beam.bdf").write_text(DECK)
    (tmp_path / "case.toml").write_text(CASE.format("spc2_3"))
    assert len(read_case(tmp_path / "case.toml").system.loads) == 1


@pytest.mark.parametrize("is_reduced", [True, False])
def test_a_force_in_python_on_a_node_without_mass_is_warned_of_once(tmp_path, is_reduced):
    (tmp_path / "beam.bdf").write_text(DECK)
    model = deck_model(read_deck(tmp_path / "beam.bdf"))
    body = flexible_body("arm", model, [AveragingInterface("end", "spc2_3")]).linearized()
    frame = MeanAxisFrame()
    form = (
        reduce(body, frame, NoLoads(Rubin(1)), derivatives=NoDerivatives())
        if is_reduced
        else FullBody(body, frame)
    )
    unloaded = System([form])
    force = DeadForce(body="arm", at=[1], force=[0.0, 0.0, 10.0])
    with pytest.warns(BasisWarning, match=r"on 1 nodes of 'arm': node 12 \(one of 1\) has no mass"):
        system = replace(unloaded, loads=[force])
    assert len(replace(system, gravity=np.zeros(3)).loads) == 1


def test_a_mean_of_nodes_without_mass_is_warned_of(tmp_path):
    (tmp_path / "beam.bdf").write_text(DECK)
    model = deck_model(read_deck(tmp_path / "beam.bdf"))
    assert flexible_body("arm", model, [AveragingInterface("end", "spc2_3")]).massless.tolist() == [1]
    with pytest.warns(BasisWarning, match="body 'arm', interface 'middle': node 12"):
        flexible_body("arm", model, [AveragingInterface("middle", "spc1_3")])

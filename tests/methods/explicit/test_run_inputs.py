"""A result file of an explicit run gives back its own motion alone: what changes it is named."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar

from supple.body import flexible_body
from supple.errors import ResultFileError
from supple.fem import solid_model
from supple.integrate import Run
from supple.machine import (
    At,
    Contact,
    DeadForce,
    Placed,
    RigidPlane,
    Support,
    System,
)
from supple.mesh import CellType, Mesh
from supple.methods.explicit import (
    Explicit,
    NeoHookean,
    explicit_subdomain,
    modal_subdomain,
)
from supple.reduction import NormalModes
from supple.simulation import simulate

RUN = Run(0.02, 0.01)
MODEL = bar(CellType.HEXA8)


def moved(model):
    """The same bar, a node in the middle a little aside, and its mirror node the other way."""
    nodes = model.mesh.nodes.copy()
    inside = np.flatnonzero(np.isclose(nodes[:, 0], 2.0))[:2]
    nodes[inside, 0] += [1e-7, -1e-7]
    return solid_model(Mesh(nodes, model.mesh.cells, model.mesh.node_sets), SOFT)


def system(model=MODEL, law=None, **changes):
    part = {"velocity": (0.1, 0.2, 0.0), "angular_velocity": (0.0, 0.1, 0.0)}
    of_system = {
        "gravity": (0.0, 0.0, -1.0),
        "loads": [DeadForce(at="bar.tip", force=(0.0, 1.0, 0.0))],
        "supports": [Support(At("bar", "root"), (2,))],
        "contacts": [Contact(At("bar", "tip"), RigidPlane((5.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))],
    }
    for key, value in changes.items():
        (of_system if key in of_system else part)[key] = value
    return System([Placed(explicit_subdomain(model, law, name="bar"), **part)], **of_system)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "run.h5"
    return path, simulate(system(), RUN, file=path)


def test_the_same_run_is_read(kept):
    path, solution = kept
    again = simulate(system(), RUN, file=path)
    assert np.array_equal(again.bodies["bar"].nodes, solution.bodies["bar"].nodes)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"velocity": (-0.1, 0.2, 0.0)}, "body 'bar' has changed"),
        ({"velocity": (0.2, 0.1, 0.0)}, "body 'bar' has changed"),
        ({"angular_velocity": (0.0, -0.1, 0.0)}, "body 'bar' has changed"),
        ({"gravity": (0.0, 1.0, 0.0)}, "gravity has changed"),
        ({"gravity": (0.0, 0.0, 1.0)}, "gravity has changed"),
        (
            {"loads": [DeadForce(at="bar.tip", force=(0.0, -1.0, 0.0))]},
            "load 1, DeadForce on 'tip' of 'bar' has changed",
        ),
        ({"supports": [Support(At("bar", "root"), (1,))]}, "support 1 of 'bar.root' has changed"),
        ({"contacts": []}, "contact 1 of 'bar.tip' is missing"),
        ({"law": NeoHookean(SOFT)}, "body 'bar' has changed"),
        ({"model": moved(MODEL)}, "body 'bar' has changed"),
    ],
)
def test_another_system_is_refused(kept, changes, named):
    with pytest.raises(ResultFileError, match=named):
        simulate(system(**changes), RUN, file=kept[0])


def test_another_span_and_other_options_are_refused(kept):
    with pytest.raises(
        ResultFileError, match=r"the run was 0\.02 from 0\.0, every 0\.01.*and is 0\.02 from 1\.0"
    ):
        simulate(system(), replace(RUN, start=1.0), file=kept[0])
    with pytest.raises(ResultFileError, match=r"safety=0\.9.*and is .*safety=0\.8"):
        simulate(system(), replace(RUN, method=Explicit(safety=0.8)), file=kept[0])


def test_a_motion_in_other_modes_is_not_read(tmp_path):
    """Signs and directions of modes are free: coordinates mean nothing in others."""
    body = flexible_body("box", MODEL)
    modal = modal_subdomain(body, NormalModes(4))
    path = tmp_path / "modal.h5"
    simulate(System([modal]), RUN, file=path)
    simulate(System([modal_subdomain(body, NormalModes(4))]), RUN, file=path)
    flipped = replace(modal, vectors=modal.vectors * [1, 1, -1, 1])
    with pytest.raises(ResultFileError, match="body 'box' in 4 modes whose shapes are not those"):
        simulate(System([flipped]), RUN, file=path)
    with pytest.raises(ResultFileError, match="body 'box' has changed"):
        simulate(System([modal_subdomain(body, NormalModes(5))]), RUN, file=path)

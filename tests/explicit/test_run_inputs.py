"""A result file of an explicit run gives back its own motion alone: what changes it is named."""

from dataclasses import replace

import numpy as np
import pytest
from fixtures.explicit_bars import SOFT, bar

from supple.body import flexible_body
from supple.errors import ResultFileError
from supple.explicit import (
    Contact,
    ExplicitOptions,
    ExplicitSystem,
    NeoHookean,
    NodalForce,
    Part,
    RigidPlane,
    Support,
    explicit_subdomain,
    modal_subdomain,
    simulate_explicit,
)
from supple.fem import solid_model
from supple.integrate import Run
from supple.machine import At
from supple.mesh import CellType, Mesh
from supple.reduction import NormalModes

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
        "forces": [NodalForce(At("bar", "tip"), (0.0, 1.0, 0.0))],
        "supports": [Support(At("bar", "root"), (2,))],
        "contacts": [Contact(At("bar", "tip"), RigidPlane((5.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))],
    }
    for key, value in changes.items():
        (of_system if key in of_system else part)[key] = value
    return ExplicitSystem([Part(explicit_subdomain(model, law, name="bar"), **part)], **of_system)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    path = tmp_path_factory.mktemp("kept") / "run.h5"
    return path, simulate_explicit(system(), RUN, file=path)


def test_the_same_run_is_read(kept):
    path, solution = kept
    again = simulate_explicit(system(), RUN, file=path)
    assert np.array_equal(again.bodies["bar"].nodes, solution.bodies["bar"].nodes)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"velocity": (-0.1, 0.2, 0.0)}, "part 'bar' has changed"),
        ({"velocity": (0.2, 0.1, 0.0)}, "part 'bar' has changed"),
        ({"angular_velocity": (0.0, -0.1, 0.0)}, "part 'bar' has changed"),
        ({"gravity": (0.0, 1.0, 0.0)}, "gravity has changed"),
        ({"gravity": (0.0, 0.0, 1.0)}, "gravity has changed"),
        ({"forces": [NodalForce(At("bar", "tip"), (0.0, -1.0, 0.0))]}, "force 1 of 'bar.tip' has changed"),
        ({"supports": [Support(At("bar", "root"), (1,))]}, "support 1 of 'bar.root' has changed"),
        ({"contacts": []}, "contact 1 of 'bar.tip' is gone"),
        ({"law": NeoHookean(SOFT)}, "part 'bar' has changed"),
        ({"model": moved(MODEL)}, "part 'bar' has changed"),
    ],
)
def test_another_system_is_refused(kept, changes, named):
    with pytest.raises(ResultFileError, match=named):
        simulate_explicit(system(**changes), RUN, file=kept[0])


def test_another_span_and_other_options_are_refused(kept):
    with pytest.raises(
        ResultFileError, match=r"the run was 0\.02 from 0\.0, every 0\.01 and is 0\.02 from 1\.0"
    ):
        simulate_explicit(system(), replace(RUN, start=1.0), file=kept[0])
    with pytest.raises(ResultFileError, match=r"the option safety was 0\.9 and is 0\.8"):
        simulate_explicit(system(), RUN, options=ExplicitOptions(safety=0.8), file=kept[0])


def test_a_motion_in_other_modes_is_not_read(tmp_path):
    """Signs and directions of modes are free: coordinates mean nothing in others."""
    body = flexible_body("box", MODEL)
    modal = modal_subdomain(body, NormalModes(4))
    path = tmp_path / "modal.h5"
    simulate_explicit(ExplicitSystem([modal]), RUN, file=path)
    simulate_explicit(ExplicitSystem([modal_subdomain(body, NormalModes(4))]), RUN, file=path)
    flipped = replace(modal, vectors=modal.vectors * [1, 1, -1, 1])
    with pytest.raises(ResultFileError, match="part 'box' in 4 modes whose shapes are not those"):
        simulate_explicit(ExplicitSystem([flipped]), RUN, file=path)
    with pytest.raises(ResultFileError, match="part 'box' has changed"):
        simulate_explicit(ExplicitSystem([modal_subdomain(body, NormalModes(5))]), RUN, file=path)

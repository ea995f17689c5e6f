"""Models condensed elsewhere in machines and case files: the motion of the body that is reduced here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fixtures.beam_bodies import beam_body
from fixtures.condensed_beam import condensed_beam, inside, write_condensed_hdf5
from scipy.io import mmwrite
from typer.testing import CliRunner

from supple.body import AveragingInterface, FullBody, NodalFixedFrame, Recovery, RigidInterface, superelement
from supple.cases import read_case, run_case
from supple.cli.main import app
from supple.errors import CaseError, ModelError
from supple.integrate import FixedStep, Run
from supple.machine import PrescribedRotation, Ramp, System
from supple.methods.explicit import modal_subdomain
from supple.quantities import Place, PositionSensor
from supple.reduction import CompleteBasis, CraigBampton, NoDerivatives, NoLoads, reduce
from supple.simulation import simulate
from supple.simulation.stored_basis import stored_basis

MODES = 6
RUN = Run(1.0, 0.005, step=FixedStep(0.005))
CASE = """\
title = "arm"

[[body]]
name = "arm"
mesh = "arm.h5"
matrices = { stiffness = "arm.h5", mass = "arm.h5", recovery = "arm.h5" }
frame = { kind = "nodal-fixed", interface = "root" }
reduction = { basis = "complete" }

[[body.interface]]
name = "root"
node_indices = [20]

[[body.interface]]
name = "tip"
node_indices = [10]

[[joint]]
name = "shaft"
kind = "prescribed-rotation"
first = "ground"
second = "arm.root"
axis = [0.0, 0.0, 1.0]
law = { kind = "ramp", value = 0.5, duration = 1.0 }

[simulation]
duration = 1.0
output_step = 0.005
step = 0.005

[output]
track = ["arm.tip"]
pictures = false
animation = false
report = false
"""


@pytest.fixture(scope="module")
def beam():
    return condensed_beam(MODES)


def driven(body):
    shaft = PrescribedRotation(
        first="ground", second=f"{body.name}.root", axis=(0, 0, 1), angle=Ramp(0.5, 1.0)
    )
    return System(bodies=[body], joints=[shaft])


def reduced(body, basis):
    return reduce(body, NodalFixedFrame("root"), basis, derivatives=NoDerivatives(), loads=NoLoads)


@pytest.fixture(scope="module")
def ours():
    """Machine and motion of the same beam, reduced here."""
    system = driven(reduced(beam_body("root", "tip").linearized(), CraigBampton(MODES)))
    return system, simulate(system, RUN)


@pytest.mark.slow
def test_the_machine_moves_as_with_the_body_reduced_here(beam, ours):
    """Half a turn of a tenth of the lowest frequency: the swing of the tip, and of a point inside."""
    points, T, ids = inside(beam)
    body = superelement(
        *("beams", beam.grids, beam.stiffness, beam.mass),
        dofs_per_node=6,
        interfaces=[RigidInterface("root", [0]), RigidInterface("tip", [1])],
        recovery=Recovery(points, ids, T),
    )
    machine = driven(reduced(body, CompleteBasis()))
    motion = simulate(machine, RUN)
    system, exact = ours
    middle = int(np.flatnonzero(points[:, 0] == 2.0)[0])
    for place, other in (("tip", "tip"), ((2 + middle,), (5,))):
        found = PositionSensor("p", Place("beams", place)).values(machine, motion)
        wanted = PositionSensor("p", Place("beams", other)).values(system, exact)
        s = exact.times
        angle = 0.5 * s**3 * (10 - 15 * s + 6 * s**2)
        rigid = wanted[0, 0] * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        bent = np.abs(wanted - rigid).max()
        assert np.abs(found - wanted).max() < 0.01 * bent


def write(folder, beam, text=CASE):
    write_condensed_hdf5(folder / "arm.h5", beam)
    (folder / "arm.toml").write_text(text)
    return folder / "arm.toml"


@pytest.mark.slow
def test_a_case_runs_is_checked_and_has_modes(tmp_path, beam, ours):
    path = write(tmp_path, beam)
    run = run_case(read_case(path), tmp_path / "out", errors=False)
    system, exact = ours
    tip = PositionSensor("p", Place("beams", "tip")).values(system, exact)[-1]
    found = PositionSensor("p", Place("arm", "tip")).values(run.system, run.solution)[-1]
    np.testing.assert_allclose(found, tip, atol=1e-3)
    for command in (
        ["check", str(path)],
        ["info", str(path)],
        ["modes", str(path)],
        ["check", str(tmp_path / "arm.h5")],
    ):
        result = CliRunner().invoke(app, command)
        assert result.exit_code == 0, result.output
        if command[0] == "check":
            assert "modal coordinates" in result.output


def test_matrix_market_files_have_modal_rows_behind_those_of_the_nodes(tmp_path, beam):
    points, T, _ = inside(beam)
    given = {
        "K": beam.stiffness,
        "M": beam.mass,
        "C": 0.01 * beam.stiffness,
        "x": beam.grids,
        "T": T,
        "p": points,
    }
    for name, matrix in given.items():
        mmwrite(tmp_path / f"{name}.mtx", matrix, precision=17)
    files = 'stiffness = "K.mtx", mass = "M.mtx", damping = "C.mtx", nodes = "x.mtx", recovery = "T.mtx"'
    text = CASE.replace('mesh = "arm.h5"\n', "").replace(
        'matrices = { stiffness = "arm.h5", mass = "arm.h5", recovery = "arm.h5" }',
        f'superelement = {{ {files}, points = "p.mtx", dofs_per_node = 6 }}',
    )
    (tmp_path / "arm.toml").write_text(text.replace("[20]", "[0]").replace("[10]", "[1]"))
    case = read_case(tmp_path / "arm.toml")
    assert case.sources["arm"].check(3).is_accepted
    body = case.flexible["arm"]
    assert (body.n_modal, len(body.nodes)) == (MODES, 2 + len(points))
    assert abs(body.damping - 0.01 * body.stiffness).max() < 1e-12 * abs(body.stiffness).max()


@pytest.mark.slow
def test_recovered_points_can_be_averaged_but_not_tied(tmp_path, beam):
    more = '[[body.interface]]\nname = "inside"\nkind = "KIND"\nnode_indices = [103, 104, 105]\n\n[[joint]]'
    path = write(tmp_path, beam, CASE.replace("[[joint]]", more.replace("KIND", "rigid"), 1))
    with pytest.raises(ModelError, match=r"interface 'inside': a recovered point follows the boundary"):
        _ = read_case(path).flexible
    around = np.array([[0.0, 0.1, 0], [0, -0.1, 0], [0, 0, 0.1]])
    u, theta = beam.recovery[30:33], beam.recovery[33:36]  # of the node in the middle
    T = np.concatenate([u + np.cross(theta, arm, axisa=0, axisc=0) for arm in around])
    body = superelement(
        *("arm", beam.grids, beam.stiffness, beam.mass),
        dofs_per_node=6,
        interfaces=[AveragingInterface("inside", [2, 3, 4], position=(2, 0, 0))],
        recovery=Recovery(around + np.array([2.0, 0, 0]), np.arange(3), T),
    )
    motion = body.interface("inside").motion.toarray()
    np.testing.assert_allclose(motion, np.vstack([u, theta]), atol=1e-12)


def test_its_nodes_do_not_show_which_coordinates_a_basis_keeps(beam):
    ends = [RigidInterface("root", [0]), RigidInterface("tip", [1])]
    body = superelement("arm", beam.grids, beam.stiffness, beam.mass, dofs_per_node=6, interfaces=ends)
    small = reduced(body, CraigBampton(2))
    assert small.full is None
    with pytest.raises(ModelError, match=r"is a condensed model, .* Keep all coordinates: CompleteBasis"):
        stored_basis(FullBody(body, NodalFixedFrame("root")), small)
    with pytest.raises(ModelError, match="the mass distribution of a body condensed elsewhere"):
        modal_subdomain(body, CraigBampton(2))
    with pytest.raises(ModelError, match="a damping matrix is not supported"):
        modal_subdomain(replace(body, damping=body.stiffness), CraigBampton(2))


def test_keys_of_a_recovery(tmp_path, beam):
    path = write(tmp_path, beam, CASE.replace('recovery = "arm.h5"', 'recovery = "arm.h5", recover = "x"'))
    with pytest.raises(CaseError, match="recover"):
        read_case(path)

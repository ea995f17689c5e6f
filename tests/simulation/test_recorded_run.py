"""A simulation that lives on disk: begun, read, continued, never mixed up with another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from supple.body import MeanAxisFrame, RigidBody, RigidInterface, flexible_body
from supple.errors import ConvergenceError, ModelError, ResultFileError
from supple.fem import Isotropic, solid_model
from supple.integrate import FixedStep, Run, Tolerances
from supple.machine import GROUND, At, Placed, PrescribedRotation, Revolute, System, Table
from supple.mesh import CellType, block
from supple.reduction import NoDerivatives, NoLoads, NormalModes, reduce
from supple.simulation import simulate, simulate_recorded
from supple.storage import ResultFile, read_header

RUN = Run(duration=1.0, output_step=0.05)


@pytest.fixture
def pendulum():
    bar = RigidBody("bar", 1.0, (0.5, 0.0, 0.0), np.diag([0.01, 0.1, 0.1]), {"pin": (0.0, 0.0, 0.0)})
    pin = Revolute(name="pin", first=GROUND, second=At("bar", "pin"), axis=(0.0, 1.0, 0.0))
    return System(bodies=(Placed(bar),), joints=(pin,), gravity=(0.0, 0.0, -9.81))


def test_the_run_is_that_of_simulate_and_is_on_disk(tmp_path, pendulum):
    path = tmp_path / "new folder" / "run.h5"
    kept = simulate_recorded(pendulum, RUN, path, case="pendulum")
    direct = simulate(pendulum, RUN)
    np.testing.assert_array_equal(kept.bodies["bar"].rotation, direct.bodies["bar"].rotation)
    assert read_header(path).complete


def test_a_complete_run_is_read_not_repeated(tmp_path, pendulum):
    shares = []
    first = simulate_recorded(pendulum, RUN, tmp_path / "run.h5", case="pendulum")
    again = simulate_recorded(pendulum, RUN, tmp_path / "run.h5", case="pendulum", progress=shares.append)
    assert again.statistics == first.statistics  # its wall time among them
    assert shares == [1.0]


def test_a_run_cut_off_is_continued(tmp_path, pendulum):
    """What a kill leaves behind is kept as it is, and the rest follows the uninterrupted motion."""

    class KilledError(Exception):
        pass

    def kill(share: float) -> None:
        if share > 0.4:
            raise KilledError

    path = tmp_path / "run.h5"
    with pytest.raises(KilledError):
        simulate_recorded(pendulum, RUN, path, case="pendulum", progress=kill)
    n_kept = read_header(path).n_times
    assert 5 < n_kept < 21
    whole = simulate_recorded(pendulum, RUN, path, case="pendulum")
    direct = simulate(pendulum, RUN)
    np.testing.assert_array_equal(whole.times, direct.times)
    ours, theirs = whole.bodies["bar"].rotation, direct.bodies["bar"].rotation
    np.testing.assert_array_equal(ours[:n_kept], theirs[:n_kept])
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


def test_another_run_is_not_overwritten(tmp_path, pendulum):
    simulate_recorded(pendulum, RUN, tmp_path / "run.h5", case="pendulum")
    with pytest.raises(ResultFileError, match=r"another run than .*In the file: pendulum. Requested: x"):
        simulate_recorded(pendulum, RUN, tmp_path / "run.h5", case="x")


def test_a_run_begun_anew_replaces_the_one_that_is_there(tmp_path, pendulum):
    path = tmp_path / "run.h5"
    simulate_recorded(pendulum, RUN, path, case="long")
    shorter = Run(duration=0.2, output_step=0.1)
    with pytest.raises(ResultFileError, match="set overwrite=True to replace it"):
        simulate_recorded(pendulum, shorter, path, case="short")
    with pytest.raises(ResultFileError, match="it contains a finished run; give overwrite=True to replace"):
        ResultFile.create(path, case="short")
    assert read_header(path).case == "long"
    short = simulate_recorded(pendulum, shorter, path, case="short", overwrite=True)
    np.testing.assert_allclose(short.times, [0.0, 0.1, 0.2])
    header = read_header(path)
    assert (header.case, header.metadata, header.n_times) == ("short", {"pin: second end": "bar.pin"}, 3)


def test_only_what_was_cut_off_can_be_continued(tmp_path, pendulum):
    path = tmp_path / "run.h5"
    with pytest.raises(ResultFileError, match=r"run\.h5"):
        ResultFile.resume(path, case="pendulum")
    simulate_recorded(pendulum, RUN, path, case="pendulum")
    with pytest.raises(ResultFileError, match="its run is complete"):
        ResultFile.resume(path, case="pendulum")


def test_a_load_table_shorter_than_the_run_is_refused_at_its_start(tmp_path):
    bar = RigidBody("bar", 1.0, (0.5, 0.0, 0.0), np.diag([0.01, 0.1, 0.1]), {"pin": (0.0, 0.0, 0.0)})
    short = Table([0.0, 0.5], [0.0, 1.0])
    motor = PrescribedRotation(
        name="motor", first=GROUND, second=At("bar", "pin"), axis=(0.0, 0.0, 1.0), angle=short
    )
    with pytest.raises(ModelError, match=r"motor.*its table ends at t = 0.5, before the run ends"):
        simulate_recorded(System((Placed(bar),), (motor,)), RUN, tmp_path / "run.h5", case="short")


def test_what_was_computed_before_a_failure_is_kept(tmp_path, pendulum):
    """One iteration a step is enough at first, but not when the pendulum is fast."""
    path = tmp_path / "run.h5"
    with pytest.raises(ConvergenceError):
        simulate_recorded(
            pendulum,
            Run(
                duration=1.0,
                output_step=0.02,
                step=FixedStep(0.02, smallest=0.015),
                tolerances=Tolerances(residual=1e-4, max_iterations=1),
            ),
            path,
            case="pendulum",
        )
    header = read_header(path)
    assert not header.complete
    assert header.n_times >= 2


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"stiffness": np.diag([1.5e3, 1e9])}, "frequencies"),
        ({"damping": np.diag([0.15, 1e5])}, "damping of modes"),
        ({"interfaces": ()}, "interface 'root'"),
    ],
)
def test_a_soft_mode_and_an_interface_are_part_of_a_body(tmp_path, changed, named):
    """Beside a stiff mode, a soft one changes no product of the whole matrix."""
    model = solid_model(block(1.0, 0.1, 0.1, 4, 1, 1, CellType.HEXA20), Isotropic(1e9, 0.3, 1000.0))
    bar = flexible_body("bar", model, [RigidInterface("root", "root")]).linearized()
    body = reduce(bar, MeanAxisFrame(), NormalModes(2), derivatives=NoDerivatives(), loads=NoLoads)
    body = replace(body, stiffness=np.diag([1e3, 1e9]), damping=np.diag([0.1, 1e5]))
    path, run = tmp_path / "run.h5", Run(0.02, 0.01)
    simulate_recorded(System(bodies=(Placed(body),)), run, path, case="bar")
    if "interfaces" in changed:
        (root,) = body.interfaces
        changed = {"interfaces": (replace(root, position=np.add(root.position, [0.1, 0.0, 0.0])),)}
    with pytest.raises(ResultFileError, match=f"with another {named} than the given body"):
        simulate_recorded(System(bodies=(Placed(replace(body, **changed)),)), run, path, case="bar")


def test_a_motion_is_never_taken_for_one_on_other_columns(tmp_path):
    """Modes have no sign of their own: a body reduced once more may move the other way."""
    model = solid_model(block(1.0, 0.1, 0.1, 4, 1, 1, CellType.HEXA20), Isotropic(1e9, 0.3, 1000.0))
    bar = flexible_body("bar", model, [RigidInterface("root", "root")]).linearized()
    body = reduce(bar, MeanAxisFrame(), NormalModes(2), derivatives=NoDerivatives(), loads=NoLoads)
    flipped = replace(body, nodal_basis=body.nodal_basis * [1.0, -1.0])
    nearly = replace(body, nodal_basis=body.nodal_basis * (1 + 1e-9))
    path, run = tmp_path / "run.h5", Run(0.02, 0.01)
    first = simulate_recorded(System(bodies=(Placed(body),)), run, path, case="bar")
    again = simulate_recorded(System(bodies=(Placed(nearly),)), run, path, case="bar")
    assert again.statistics == first.statistics
    with pytest.raises(ResultFileError, match="motion of body 'bar' in 2 columns that are not those"):
        simulate_recorded(System(bodies=(Placed(flipped),)), run, path, case="bar")

"""Lines from Nastran's files: what we condense, written as Nastran writes it, and read back."""

import numpy as np
import pytest
from fixtures.beam_lines import beam_line
from scipy import linalg
from scipy.spatial.transform import Rotation

from supple.errors import ModelError
from supple.export import write_dmig_punch
from supple.methods.intrinsic import CLAMPED, intrinsic_modes, read_condensed_line

POINTS = np.array([[0, 0, 0], [0.5, 0.1, 0], [1.0, 0.2, 0.1], [1.5, 0.1, 0.1], [0.9, 0.7, 0.1]])
PARENTS = [-1, 0, 1, 2, 2]
GRIDS = np.array([40, 10, 20, 30, 5])
PATHS = [[40, 10, 20, 30], [20, 5]]
ALL = np.arange(5)
TURN = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
DIGITS = 2e-8
"""Of the largest entry: ten printed digits, times the entries that cleaning adds up."""


@pytest.fixture(scope="module")
def tree():
    return beam_line(POINTS, parents=PARENTS, EA=1e3, EI=(1.0, 2.0), GJ=1.0, mass_per_length=1.3, radius=0.05)


def bulk_data(path, *, grids=GRIDS, components=123456, turned=()):
    """GRID and ASET1 cards; some grids displaced along axes of their own."""
    x, z = TURN[:, 0], TURN[:, 2]
    lines = [
        "BEGIN BULK",
        "CORD2R,7,,0.,0.,0.," + ",".join(f"{v:.6f}" for v in z),
        "," + ",".join(f"{v:.6f}" for v in x),
    ]
    for grid, point in zip(GRIDS, POINTS, strict=True):
        place = ",".join(f"{v:.6f}" for v in point)
        lines.append(f"GRID,{grid},,{place},{7 if grid in turned else ''}")
    lines += [f"ASET1,{components},{grid}" for grid in grids]
    path.write_text("\n".join([*lines, "ENDDATA"]) + "\n")
    return path


def along_own_axes(matrix, turned):
    blocks = [np.kron(np.eye(2), TURN if grid in turned else np.eye(3)) for grid in GRIDS]
    turn = linalg.block_diag(*blocks)
    return turn.T @ matrix @ turn


def files(folder, tree, *, turned=(), rows=ALL, **changes):
    """Bulk data and a punch of KAAX and MAAX, rows of grids in another order than the stations."""
    K = changes.get("stiffness", along_own_axes(tree.stiffness, turned))
    M = changes.get("mass", along_own_axes(tree.mass, turned))
    grids = GRIDS[rows]
    chosen = (6 * rows[:, None] + np.arange(6)).ravel()
    punch = write_dmig_punch(
        folder / "out.pch", grids, 6, KAAX=K[np.ix_(chosen, chosen)], MAAX=M[np.ix_(chosen, chosen)]
    )
    nodes = bulk_data(folder / "model.bdf", grids=grids, turned=turned)
    return {"nodes": nodes, "stiffness": punch, "mass": punch}


def assert_same(read, line):
    assert read.tree.points == pytest.approx(line.tree.points)
    assert np.array_equal(read.tree.parents, line.tree.parents)
    assert np.abs(read.stiffness - line.stiffness).max() < DIGITS * np.abs(line.stiffness).max()
    assert np.abs(read.mass - line.mass).max() < DIGITS * np.abs(line.mass).max()


@pytest.mark.parametrize("turned", [(), (10, 5)])
def test_a_punched_tree_is_read_back(tmp_path, tree, turned):
    """To the digits of the file; grids may be displaced along axes of their own (CD), given to six digits."""
    given = files(tmp_path, tree, turned=turned)
    read = read_condensed_line("beam", paths=PATHS, **given)
    if not turned:
        assert_same(read, tree)
    own, exact = (intrinsic_modes(line, CLAMPED, 10).omega for line in (read, tree))
    assert own == pytest.approx(exact, rel=1e-5)


def test_a_clamped_root_may_be_missing(tmp_path, tree):
    given = files(tmp_path, tree, rows=ALL[1:])
    read = read_condensed_line("beam", paths=PATHS, root_mass=tree.mass[:6, :6], **given)
    assert_same(read, tree)
    massless = read_condensed_line("beam", paths=PATHS, **given)
    assert massless.total_mass == pytest.approx(tree.total_mass - tree.mass[0, 0])


@pytest.mark.slow
def test_output4_has_the_order_of_the_analysis_set(tmp_path, tree):
    op4 = pytest.importorskip("pyyeti.nastran.op4")
    order = np.argsort(GRIDS)
    rows = (6 * order[:, None] + np.arange(6)).ravel()
    square = np.ix_(rows, rows)
    file = tmp_path / "out.op4"
    op4.write(str(file), {"KAA": tree.stiffness[square], "MAA": tree.mass[square]})
    nodes = bulk_data(tmp_path / "model.bdf")
    read = read_condensed_line("beam", nodes=nodes, stiffness=file, mass=file, paths=PATHS)
    assert_same(read, tree)


def test_grids_hang_on_one_another_in_the_order_of_the_file_unless_paths_are_given(tmp_path, tree):
    read = read_condensed_line("beam", **files(tmp_path, tree))
    assert read.tree.is_chain
    assert read.tree.points == pytest.approx(POINTS)


@pytest.mark.parametrize(
    ("paths", "message"),
    [
        ([[40, 10, 20, 30]], "grid 5 of .* is on no load path"),
        ([[40, 10, 20, 30], [20, 5, 99]], "grid 99 of its path is not defined"),
        ([[40, 10, 20, 30], [77, 5]], "begins at grid 77, which is on no earlier path"),
        ([[40, 10, 20, 30, 10], [20, 5]], "grid 10 occurs twice"),
        ([[40]], "at least two grids"),
        ([], "no load path is given"),
    ],
)
def test_paths_that_do_not_fit_are_named(tmp_path, tree, paths, message):
    with pytest.raises(ModelError, match=message):
        read_condensed_line("beam", paths=paths, **files(tmp_path, tree))


def test_matrices_that_are_no_condensation_are_refused(tmp_path, tree):
    def refused(message, given, **options):
        with pytest.raises(ModelError, match=message):
            read_condensed_line("beam", **({"paths": PATHS} | given | options))

    refused("stiffness is negative at station", files(tmp_path, tree, stiffness=-tree.stiffness))
    refused("mass is negative at station", files(tmp_path, tree, mass=-tree.mass))
    refused("leave out root_mass", files(tmp_path, tree), root_mass=np.eye(6))
    grounded = tree.stiffness.copy()
    grounded[:6, :6] += 1e3 * np.eye(6)
    refused(r"rigid motion causes forces .* \(read from", files(tmp_path, tree, stiffness=grounded))
    middle = files(tmp_path, tree, rows=np.array([0, 1, 3, 4]))
    refused("grid 20 of its path is in no matrix", middle)


def test_a_grid_with_some_of_its_freedoms_is_refused(tmp_path, tree):
    given = files(tmp_path, tree)
    lines = given["stiffness"].read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if "KAAX" in line and line.endswith(" 5               6"))
    end = next(i for i in range(start + 1, len(lines)) if lines[i].startswith("DMIG"))
    kept = lines[:start] + lines[end:]
    kept = [line for line in kept if not line.startswith("*                      5               6")]
    punch = tmp_path / "cut.pch"
    punch.write_text("\n".join(kept) + "\n")
    with pytest.raises(ModelError, match=r"grid 5 has freedoms 12345 .* 123456 of all stations"):
        read_condensed_line("beam", paths=PATHS, **(given | {"stiffness": punch}))

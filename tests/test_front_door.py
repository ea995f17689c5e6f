"""`import supple as sp`: quick, complete, documented, and the same for people and for type checkers."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import supple as sp
from supple.errors import SuppleError

HEAVY = ("numpy", "scipy", "jax", "h5py", "matplotlib", "pydantic", "supple_benchmarks")
# `supple.cases` reads case files; until it is there, its name alone has no object behind it.
NAMES = [name for name in sp.__all__ if name != "read_case" or find_spec("supple.cases")]


def loaded_by(program):
    """Those heavy packages that a program loads, run in an interpreter of its own."""
    report = f"\nimport sys\nprint('LOADED', *[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", program + report], capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()[-1].split()[1:]


VERSION_AND_HELP = """
import sys
from supple.cli.main import main
for sys.argv in (["supple", "--version"], ["supple", "--help"]):
    try:
        main()
    except SystemExit as done:
        assert not done.code
"""


def test_the_import_loads_no_package_of_numbers():
    assert loaded_by("import supple") == []


def test_a_name_loads_what_it_needs():
    """So that the test before sees what is loaded."""
    assert "numpy" in loaded_by("import supple; supple.strip")


def test_version_and_help_wait_neither_for_solvers_nor_for_benchmarks():
    assert not {"jax", "scipy", "matplotlib", "supple_benchmarks"} & set(loaded_by(VERSION_AND_HELP))


NOT_OF_A_RUN = (
    "matplotlib",
    "scipy.fft",
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.signal",
    "scipy.stats",
    "supple.export",
    "supple.report",
    "supple.sensitivity",
    "supple.sweeps",
    "supple.viz",
    "supple_benchmarks",
)
COUNTED = f"""
import sys
import supple.cli.main, supple.cli.computed_case
print(len(sys.modules), *[name for name in {NOT_OF_A_RUN} if name in sys.modules])
"""


@pytest.mark.slow
def test_a_run_waits_for_no_module_of_other_commands():
    """Modules are counted, not seconds: 1930 when this was written, of which 788 are our own."""
    shown = subprocess.run([sys.executable, "-c", COUNTED], capture_output=True, text=True, check=True)
    number, *loaded = shown.stdout.split()
    assert loaded == []
    assert int(number) < 2000


WITHOUT_PLOTTING = """
import sys
for name in ("matplotlib", "PIL", "pandas", "xarray", "IPython"):
    sys.modules[name] = None
import numpy as np
import supple as sp
bar = sp.RigidBody("bar", 1.0, [0.5, 0, 0], np.eye(3), {"root": np.zeros(3)})
hinge = sp.Revolute(first="ground", second="bar.root", axis=(0, 1, 0), name="hinge")
machine = sp.System([bar], [hinge], gravity=(0, 0, -9.81))
motion = sp.simulate(machine, sp.Run(0.1, 0.05))
motion = sp.state_errors(machine, sp.Run(0.1, 0.05), motion)
sp.write_report(sys.argv[1], machine, motion)
"""


@pytest.mark.slow
def test_a_script_that_simulates_and_reports_needs_no_plotting_package(tmp_path):
    subprocess.run([sys.executable, "-c", WITHOUT_PLOTTING, str(tmp_path / "report.html")], check=True)
    assert (tmp_path / "report.html").stat().st_size > 100_000


@pytest.mark.parametrize("name", NAMES)
def test_names_resolve_and_are_documented(name):
    value = getattr(sp, name)
    text = value.__doc__ or ""
    assert len(text) > 20
    # What dataclass and NamedTuple write of themselves is no documentation.
    assert not text.startswith(f"{name}(")


def test_no_name_hides_a_sub_package():
    packages = {path.name for path in Path(sp.__file__).parent.iterdir() if path.is_dir()}
    assert not packages & set(sp.__all__)


def test_names_are_listed():
    assert set(sp.__all__) <= set(dir(sp))
    assert len(set(sp.__all__)) == len(sp.__all__)
    assert 60 <= len(sp.__all__) <= 110  # the names of four methods, of what leaves a run, and of sweeps


def test_type_checkers_see_the_same_names():
    """The imports under TYPE_CHECKING, `from HOME import NAME as NAME`, against the names at run time."""
    tree = ast.parse(Path(sp.__file__).read_text())
    (block,) = (
        node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    )
    seen = {}
    for line in block.body:
        assert isinstance(line, ast.ImportFrom)
        for alias in line.names:
            assert alias.asname == alias.name
            seen[alias.name] = line.module
    assert seen == sp._HOMES


def test_errors_can_be_caught():
    assert sp.errors.SuppleError is SuppleError
    with pytest.raises(sp.errors.ModelError):
        sp.Isotropic(youngs_modulus=-1.0, poissons_ratio=0.3, density=1.0)


def test_misspelt_names_are_corrected():
    with pytest.raises(
        AttributeError, match="module 'supple' has no attribute 'reduc'; did you mean 'reduce'"
    ):
        _ = sp.reduc
    with pytest.raises(AttributeError, match=r"module 'supple' has no attribute 'xyzzy'$"):
        _ = sp.xyzzy


def test_the_version_is_that_of_the_citation():
    citation = (Path(__file__).parents[1] / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {sp.__version__}\n" in citation

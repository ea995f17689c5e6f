"""JAX's settings: programs are kept where they were asked to be, from Python as from the command line."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import pytest

from supple.algebra import jax_settings
from supple.algebra.jax_settings import bound_programs, keep_compiled_programs


@pytest.fixture
def _restored():
    before = jax.config.jax_compilation_cache_dir
    yield
    jax.config.update("jax_compilation_cache_dir", before)


@pytest.mark.usefixtures("_restored")
def test_environment_takes_precedence(tmp_path, monkeypatch):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path / "named"))
    assert keep_compiled_programs(tmp_path / "asked") == tmp_path / "named"


@pytest.mark.usefixtures("_restored")
def test_user_cache_by_default(tmp_path, monkeypatch):
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = keep_compiled_programs()
    assert folder.parent == tmp_path / "supple" / "compiled"
    assert float(jax.jit(lambda x: 2 * x)(jnp.ones(()))) == 2.0


def test_a_user_without_home_has_no_cache(monkeypatch):
    def none():
        raise RuntimeError("Could not determine home directory.")

    for variable in ("JAX_COMPILATION_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setattr(jax_settings.Path, "home", none)
    before = jax.config.jax_compilation_cache_dir
    assert keep_compiled_programs() is None
    assert jax.config.jax_compilation_cache_dir == before
    assert not jax_settings._writable(jax_settings._user_folder())


def test_unlike_machines_share_no_programs(monkeypatch):
    """Another instruction set, or another version of the compiler, has another folder."""
    monkeypatch.undo()
    here = jax_settings.this_machine.__wrapped__()
    monkeypatch.setattr(jax_settings.platform, "machine", lambda: "another")
    there = jax_settings.this_machine.__wrapped__()
    monkeypatch.undo()
    monkeypatch.setattr(jax_settings, "version", lambda name: "0.0.0")
    later = jax_settings.this_machine.__wrapped__()
    assert len({here, there, later}) == 3


@pytest.mark.slow
def test_programs_are_kept_from_python(tmp_path):
    """Importing the package is enough, and an earlier choice of the folder stays; small ones too."""
    script = (
        "import supple.methods.floating; from jax import config as c; "
        "print(c.jax_compilation_cache_dir, c.jax_persistent_cache_min_compile_time_secs)"
    )
    bare = {key: value for key, value in os.environ.items() if key != "JAX_COMPILATION_CACHE_DIR"}
    for more, expected in (
        ({"XDG_CACHE_HOME": str(tmp_path)}, str(tmp_path / "supple" / "compiled")),
        ({"JAX_COMPILATION_CACHE_DIR": str(tmp_path / "mine")}, str(tmp_path / "mine")),
    ):
        shown = subprocess.run(
            [sys.executable, "-c", script], env=bare | more, capture_output=True, text=True, check=True
        )
        assert shown.stdout.startswith(expected)
        assert shown.stdout.endswith(" 0.0\n")


@pytest.fixture
def look(tmp_path, monkeypatch):
    """What is found after 64 new programs where a process may have a number of memory maps."""
    limit = tmp_path / "max_map_count"
    monkeypatch.setattr(jax_settings, "_MOST_MAPS", limit)

    def found(most, built=64):
        limit.write_text(f"{most}\n")
        monkeypatch.setattr(jax_settings._Process, "compiled_since_looked", built)
        return bound_programs()

    return found


def test_programs_are_given_back_where_they_fill_two_thirds_of_the_memory_maps(look, monkeypatch):
    """Beyond the limit of the system the compiler would end the process."""
    given_back = []
    monkeypatch.setattr(jax_settings, "release_programs", lambda: given_back.append(1))
    assert not look(1_000_000_000)
    assert not look(100, built=63), "too few were built since it was looked at"
    assert not given_back
    assert look(100)
    assert given_back


@pytest.mark.parametrize(
    ("held", "left", "released"), [(1000, 1e6, True), (999, 1e6, False), (1000, 1e15, False)]
)
def test_a_thousand_programs_are_released_where_memory_runs_out(look, monkeypatch, held, left, released):
    """The process of the tests holds more than a megabyte, and less than a petabyte."""
    calls = []
    monkeypatch.setattr(jax_settings, "release_programs", lambda: calls.append(1))
    monkeypatch.setattr(jax_settings, "available_memory", lambda: left)
    monkeypatch.setattr(jax_settings._Process, "held", held)
    assert look(1_000_000_000) is released
    assert bool(calls) is released


@pytest.mark.slow  # and all tests after it compile anew
def test_programs_that_were_given_back_run_as_before(look):
    built = [jax.jit(lambda x, n=n: jnp.sin(x) * n) for n in range(4)]
    before = [float(program(1.0)) for program in built]
    assert look(100)
    assert built[3]._cache_size() == 0
    assert [float(program(1.0)) for program in built] == before


def test_flags_that_are_set_stay():
    names = [
        "--xla_backend_extra_options",
        "--xla_cpu_experimental_ynn_fusion_type",
        "--xla_cpu_parallel_codegen_split_count",
    ]
    assert [flag.split("=")[0] for flag in jax_settings._with_flags("").split()] == names
    given = f"{names[0]}=mine=1 --xla_cpu_enable_fast_math=false"
    completed = f"{given} {names[1]}= {names[2]}=1"
    assert jax_settings._with_flags(given) == jax_settings._with_flags(completed) == completed

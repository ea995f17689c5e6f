"""Kept programs: found by structure without tracing, by text where sources changed, and never a wrong one."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.machine import TimeFunction
from supple.programs import program_cache, program_digest
from supple.programs.program_cache import CachedProgram


@pytest.fixture
def traced(monkeypatch):
    """Functions that were traced, in their order: no process but the first one should trace any."""
    seen = []
    jit = jax.jit

    def counted(function, **options):
        seen.append(function.__name__)
        return jit(function, **options)

    monkeypatch.setattr(program_cache.jax, "jit", counted)
    return seen


VECTOR = np.array([0.3, -0.2, 0.5])


def test_later_process_neither_traces_nor_compiles(kept, traced):
    first = CachedProgram(rotation_exp)(VECTOR)
    assert traced == ["kept_rotation_exp"]
    again = CachedProgram(rotation_exp)(VECTOR)
    assert traced == ["kept_rotation_exp"]
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(CachedProgram(rotation_exp)(2 * VECTOR), rotation_exp(2 * VECTOR))


def test_changed_sources_are_traced_and_found_by_their_text(kept, traced, monkeypatch):
    first = CachedProgram(rotation_exp)(VECTOR)
    programs = sorted((kept / "by-text").iterdir())
    monkeypatch.setattr(program_cache, "digest_of_sources", lambda: "of another version")
    np.testing.assert_array_equal(CachedProgram(rotation_exp)(VECTOR), first)
    assert traced == 2 * ["kept_rotation_exp"]
    assert sorted((kept / "by-text").iterdir()) == programs


def test_sources_that_do_not_count_stand_above_all_programs():
    """What the digest leaves out is what the layers put above the error equation; it keeps no program."""
    root = Path(__file__).parents[2]
    with (root / "pyproject.toml").open("rb") as file:
        layers = tomllib.load(file)["tool"]["importlinter"]["contracts"][0]["layers"]
    (first,) = (number for number, layer in enumerate(layers) if "supple.error" in layer.split(" | "))
    above = layers[:first]
    names = [name.removeprefix("supple.") for layer in above for name in layer.split(" | ")]
    assert sorted(names) == sorted(program_digest._ABOVE)
    for name in names:
        for path in (root / "src" / "supple" / name).rglob("*.py"):
            assert "CachedProgram" not in path.read_text()


def test_broken_file_is_built_anew(kept, traced):
    first = CachedProgram(rotation_exp)(VECTOR)
    (file,) = (kept / "by-text").iterdir()
    file.write_bytes(file.read_bytes()[:-9])
    np.testing.assert_array_equal(CachedProgram(rotation_exp)(VECTOR), first)
    assert traced == 2 * ["kept_rotation_exp"]
    CachedProgram(rotation_exp)(VECTOR)
    assert len(traced) == 2


def test_nothing_is_kept_where_the_system_allows_none(kept, monkeypatch):
    """A name that is too long is refused at each call, as a folder that may not be searched is."""
    monkeypatch.setattr(program_cache, "_folder", lambda: kept / (300 * "x"))
    np.testing.assert_array_equal(CachedProgram(rotation_exp)(VECTOR), rotation_exp(VECTOR))


def test_the_folder_is_bounded_and_the_program_read_last_stays(kept, monkeypatch):
    monkeypatch.setattr(program_cache, "_MOST_KEPT", 100_000)
    (kept / "by-text").mkdir()
    for read, name in enumerate(("of JAX", "by-text/old", "by-text/young")):
        (kept / name).write_bytes(bytes(40_000))
        os.utime(kept / name, (1e9 + read, 1e9 - read))
    CachedProgram(rotation_exp)(VECTOR)
    assert not (kept / "of JAX").exists()
    assert len(list((kept / "by-text").iterdir())) == 3


def scaled_by(factor):
    return lambda time: factor * jnp.sin(np.pi * time) + sum(part for part in (time, OFFSET))


OFFSET = 1.0


def test_functions_of_the_users_own_are_known_by_what_they_do(kept, traced, monkeypatch):
    def value(factor):
        return float(CachedProgram(TimeFunction.__call__)(TimeFunction(scaled_by(factor)), 0.5))

    assert [value(factor) for factor in (2.0, 3.0, 2.0)] == [3.5, 4.5, 3.5]
    assert len(traced) == 2
    monkeypatch.setitem(globals(), "OFFSET", 2.0)
    assert value(2.0) == 4.5
    assert len(traced) == 3


TABLE = {"factor": 2.0}


def of_a_table(time):
    return TABLE["factor"] * time


def of_an_import(time):
    import math

    return math.pi * time


def of_itself(time, n=3):
    return time if n == 0 else of_itself(time, n - 1)


def of_the_clock(time):
    return time + 0 * os.getpid()


def of_a_file(time):
    return time * (1.0 if jnp.load is None else 2.0)


@pytest.mark.parametrize(
    "function", [of_a_table, of_an_import, of_itself, of_the_clock, of_a_file, lambda time: time + id(time)]
)
def test_functions_that_take_what_is_not_known_are_not_kept(kept, traced, function):
    """Another of the same name, or this one with other surroundings, would be given the values of now."""
    law = TimeFunction(function)
    for _ in range(2):
        CachedProgram(TimeFunction.__call__)(law, 5.0)
    assert traced == ["__call__", "__call__"]
    assert not list(kept.rglob("by-*"))


def test_shapes_and_options_have_programs_of_their_own(kept, traced):
    CachedProgram(rotation_exp)(VECTOR)
    CachedProgram(rotation_exp)(VECTOR.astype(np.float32))
    CachedProgram(rotation_exp, {"xla_backend_optimization_level": 1})(VECTOR)
    assert len(traced) == 3
    assert len(list((kept / "by-text").iterdir())) == 3


def test_part_of_another_program():
    """While another program is traced, it becomes a piece of it."""
    program = CachedProgram(rotation_exp)
    stacked = np.array([VECTOR, 2 * VECTOR])
    np.testing.assert_allclose(jax.vmap(program)(stacked), jax.vmap(rotation_exp)(stacked), rtol=1e-15)


TWICE = """
import numpy as np
from supple.programs.program_cache import CachedProgram
from supple.algebra.rotation import rotation_exp
for _ in range(2):
    print(CachedProgram(rotation_exp)(np.array([0.3, -0.2, 0.5])).tolist())
"""


@pytest.mark.slow
def test_a_process_with_several_processors_reads_a_program_for_one(tmp_path):
    """Without being told, JAX reads it for all that it has, and has too few arguments for them then."""
    shown = subprocess.run(
        [sys.executable, "-c", TWICE],
        env=os.environ | {"JAX_NUM_CPU_DEVICES": "2", "JAX_COMPILATION_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    first, again = shown.stdout.splitlines()
    assert first == again
    assert list((tmp_path / "by-text").iterdir())

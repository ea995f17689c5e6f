"""Kept programs: found by structure without tracing, by text where sources changed, and never a wrong one."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple.algebra.rotation import rotation_exp
from supple.machine import Constant, Ramp, TimeFunction
from supple.programs import kept_programs, program_worker
from supple.programs.kept_programs import KeptProgram


@pytest.fixture
def traced(monkeypatch):
    """Functions that were traced, in their order: no process but the first one should trace any."""
    seen = []
    jit = jax.jit

    def counted(function, **options):
        seen.append(function.__name__)
        return jit(function, **options)

    monkeypatch.setattr(kept_programs.jax, "jit", counted)
    program_worker._bind_lapack()
    seen.clear()
    return seen


VECTOR = np.array([0.3, -0.2, 0.5])


def test_later_process_neither_traces_nor_compiles(kept, traced):
    first = KeptProgram(rotation_exp)(VECTOR)
    assert traced == ["kept_rotation_exp"]
    again = KeptProgram(rotation_exp)(VECTOR)
    assert traced == ["kept_rotation_exp"]
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(KeptProgram(rotation_exp)(2 * VECTOR), rotation_exp(2 * VECTOR))


def test_changed_sources_are_traced_and_found_by_their_text(kept, traced, monkeypatch):
    first = KeptProgram(rotation_exp)(VECTOR)
    programs = sorted((kept / "by-text").iterdir())
    monkeypatch.setattr(kept_programs, "digest_of_sources", lambda: "of another version")
    np.testing.assert_array_equal(KeptProgram(rotation_exp)(VECTOR), first)
    assert traced == 2 * ["kept_rotation_exp"]
    assert sorted((kept / "by-text").iterdir()) == programs


def test_broken_file_is_built_anew(kept, traced):
    first = KeptProgram(rotation_exp)(VECTOR)
    (file,) = (kept / "by-text").iterdir()
    file.write_bytes(file.read_bytes()[:-9])
    np.testing.assert_array_equal(KeptProgram(rotation_exp)(VECTOR), first)
    assert traced == 2 * ["kept_rotation_exp"]
    KeptProgram(rotation_exp)(VECTOR)
    assert len(traced) == 2


def test_the_folder_is_bounded_and_the_program_read_last_stays(kept, monkeypatch):
    monkeypatch.setattr(kept_programs, "_MOST_KEPT", 100_000)
    (kept / "by-text").mkdir()
    for read, name in enumerate(("of JAX", "by-text/old", "by-text/young")):
        (kept / name).write_bytes(bytes(40_000))
        os.utime(kept / name, (1e9 + read, 1e9 - read))
    KeptProgram(rotation_exp)(VECTOR)
    assert not (kept / "of JAX").exists()
    assert len(list((kept / "by-text").iterdir())) == 3


def value_of(law, time):
    """The value of a law, an argument like any other."""
    return jnp.asarray(law(time))


def test_function_of_the_users_own_is_not_kept(kept, traced):
    """It is known by its name alone: another of the same name would be given this one's values."""
    for factor in (2.0, 3.0):
        law = TimeFunction(lambda time, factor=factor: factor * time)
        program = KeptProgram(Ramp.__call__)
        assert float(program(Ramp(1.0, 2.0), 0.7)) == pytest.approx(float(Ramp(1.0, 2.0)(0.7)), rel=1e-14)
        assert float(KeptProgram(TimeFunction.__call__)(law, 5.0)) == 5.0 * factor
    assert traced == ["kept_call__", "__call__", "__call__"]


def test_functions_of_other_packages_are_not_kept(kept, traced):
    KeptProgram(value_of)(Constant(3.0), 1.0)
    KeptProgram(value_of)(Constant(3.0), 1.0)
    assert traced == ["value_of", "value_of"]
    assert not list(kept.rglob("by-*"))


def test_shapes_and_options_have_programs_of_their_own(kept, traced):
    KeptProgram(rotation_exp)(VECTOR)
    KeptProgram(rotation_exp)(VECTOR.astype(np.float32))
    KeptProgram(rotation_exp, {"xla_backend_optimization_level": 1})(VECTOR)
    assert len(traced) == 3
    assert len(list((kept / "by-text").iterdir())) == 3


def test_part_of_another_program():
    """While another program is traced, it becomes a piece of it."""
    program = KeptProgram(rotation_exp)
    stacked = np.array([VECTOR, 2 * VECTOR])
    np.testing.assert_allclose(jax.vmap(program)(stacked), jax.vmap(rotation_exp)(stacked), rtol=1e-15)


TWICE = """
import numpy as np
from supple.programs.kept_programs import KeptProgram
from supple.algebra.rotation import rotation_exp
for _ in range(2):
    print(KeptProgram(rotation_exp)(np.array([0.3, -0.2, 0.5])).tolist())
"""


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

"""The compilation cache: programs are kept where they were asked to be."""

import jax
import jax.numpy as jnp
import pytest

from supple.algebra.compilation_cache import keep_compiled_programs


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
    assert keep_compiled_programs() == tmp_path / "supple" / "compiled"
    assert float(jax.jit(lambda x: 2 * x)(jnp.ones(()))) == 2.0

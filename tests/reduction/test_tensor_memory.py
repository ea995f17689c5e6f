"""Memory of the tensors: the estimate against what a reduction takes, and refusal before it is taken."""

from __future__ import annotations

import tracemalloc

import pytest

from supple.algebra import available_memory as memory
from supple.body import MeanAxisFrame
from supple.errors import MemoryShortageError
from supple.reduction import NoDerivatives, NoLoads, Rubin, project, reduce, reduction_basis
from supple.reduction.tensors import CHUNK_BYTES, largest_fitting, tensor_memory


@pytest.fixture
def left(monkeypatch, tmp_path):
    """Sets what the system says is left, in kB."""

    def set_to(kilobytes, group="max"):
        for name, text in (
            ("meminfo", f"MemTotal: 9 kB\nMemAvailable: {kilobytes} kB\n"),
            ("memory.max", group),
            ("memory.current", "5000"),
            ("memory.stat", "anon 1000\ninactive_file 4000\n"),
        ):
            (tmp_path / name).write_text(text)
        monkeypatch.setattr(memory, "_SYSTEM", tmp_path / "meminfo")
        monkeypatch.setattr(memory, "_GROUP", tmp_path)

    return set_to


def test_the_smaller_of_system_and_container_is_left(left, monkeypatch, tmp_path):
    left(2000)
    assert memory.available_memory() == 2_048_000
    left(2000, group="501000")
    assert memory.available_memory() == 500_000
    monkeypatch.setattr(memory, "_SYSTEM", tmp_path / "none")
    monkeypatch.setattr(memory, "_GROUP", tmp_path / "none")
    assert memory.available_memory() is None
    memory.require_memory(1e30, "anything", "nothing")


@pytest.mark.parametrize(
    ("size", "words"), [(12, "12 B"), (6.7e9, "6.7 GB"), (123e6, "123 MB"), (2e13, "20 TB")]
)
def test_sizes_in_words(size, words):
    assert memory.in_words(size) == words


def test_the_largest_fitting_size_fits_and_the_next_does_not():
    for size in (1e3, 1e6, 3e9):
        r = largest_fitting(size)
        assert tensor_memory(r) <= size < tensor_memory(r + 1)


@pytest.mark.slow
def test_a_reduction_takes_no_more_than_estimated(strip_body):
    """And not so much less that it would be refused for nothing."""
    columns = reduction_basis(strip_body, MeanAxisFrame(), Rubin(n_columns=40), derivatives=NoDerivatives())
    tracemalloc.start()
    project(strip_body, columns)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    estimate = tensor_memory(columns.r)
    assert 0.4 * estimate < peak < estimate + 2 * CHUNK_BYTES


def test_tensors_that_would_not_fit_are_refused_with_the_size_that_does(strip_body, left):
    left(2_000)
    with pytest.raises(
        MemoryShortageError,
        match=r"building the tensors of body 'strip' with 20 coordinates needs about 5\.6 MB of memory, "
        r"and 2 MB are available: take at most 15 columns, or the body without its nonlinear strains",
    ):
        reduce(strip_body, MeanAxisFrame(), Rubin(n_columns=20), derivatives=NoDerivatives(), loads=NoLoads)


def test_a_linear_body_builds_no_tensors(strip_body, left):
    left(0)
    columns = {"basis": Rubin(n_columns=40), "derivatives": NoDerivatives()}
    tracemalloc.start()
    body = reduce(strip_body.linearized(), MeanAxisFrame(), **columns, loads=NoLoads)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert body.is_linear
    assert peak < 8 * (body.r * (body.r + 1) // 2) ** 2

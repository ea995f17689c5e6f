"""Shapes and amplitudes give a field back to the tolerance, with no more shapes than it has."""

import numpy as np
import pytest

from supple.report.nodal_shapes import nodal_shapes


def field_of(amplitudes, seed=1):
    """(t, 50, 3) of smooth shapes with these amplitudes (t, k)."""
    shapes = np.random.default_rng(seed).standard_normal((amplitudes.shape[1], 50, 3))
    return np.tensordot(amplitudes, shapes, 1)


def in_blocks(field, size):
    return (field[start : start + size] for start in range(0, len(field), size))


@pytest.mark.parametrize("size", [1, 7, 300])
def test_a_field_of_few_shapes_is_exact(size):
    time = np.linspace(0, 9, 300)
    field = field_of(np.column_stack([np.sin(time), 1e-2 * np.cos(3 * time), 1e-3 * time**2]))
    found = nodal_shapes(in_blocks(field, size), tolerance=1e-9)
    assert len(found.shapes) == 3
    assert np.abs(found.field - field).max() < 1e-9 * found.largest
    gram = np.einsum("inc,jnc->ij", found.shapes, found.shapes)
    assert gram == pytest.approx(np.eye(3), abs=1e-12)
    sizes = np.linalg.norm(found.amplitudes, axis=0)
    assert np.all(np.diff(sizes) < 0)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6])
def test_what_is_left_out_is_within_the_tolerance(tolerance):
    decaying = 10.0 ** -np.arange(12) * np.sin(np.outer(np.arange(400), np.linspace(0.1, 1.7, 12)))
    field = field_of(decaying)
    found = nodal_shapes(in_blocks(field, 33), tolerance=tolerance)
    error = np.abs(found.field - field).max() / np.abs(field).max()
    assert error <= tolerance
    assert len(found.shapes) <= 2 - np.log10(tolerance)


def test_what_comes_late_is_not_lost():
    """A field that is at rest but for its last instants, whose shape is none of those before."""
    amplitudes = np.zeros((200, 2))
    amplitudes[:, 0] = 1e-6
    amplitudes[-2:, 1] = 1.0
    field = field_of(amplitudes)
    found = nodal_shapes(in_blocks(field, 20), tolerance=1e-5)
    assert np.abs(found.field - field).max() <= 1e-5 * np.abs(field).max()


def test_of_what_does_not_move_there_is_no_shape():
    found = nodal_shapes([np.zeros((4, 5, 3))], tolerance=1e-5)
    assert found.shapes.shape == (0, 5, 3)
    assert np.array_equal(found.field, np.zeros((4, 5, 3)))

"""Laws of time against their definitions, and smooth enough for prescribed motion."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from supple import machine
from supple.cases.laws import Constant, Ramp, Sine, SpinUp, TableLaw
from supple.cases.loads import Force
from supple.errors import ImportFormatError
from supple.quantities import Place

TIMES = np.linspace(0.0, 5.0, 101)


def sampled(law, folder):
    with jax.enable_x64(True):
        return np.asarray(jax.jit(jax.vmap(law.build(folder)))(jnp.asarray(TIMES)))


def test_constant(tmp_path):
    assert (sampled(Constant(kind="constant", value=3.0), tmp_path) == 3.0).all()


def test_sine(tmp_path):
    values = sampled(Sine(kind="sine", amplitude=2.0, frequency_hz=0.5), tmp_path)
    np.testing.assert_allclose(values, 2.0 * np.sin(np.pi * TIMES), atol=1e-14)


def test_ramp_rises_once_and_starts_and_ends_without_speed_or_acceleration(tmp_path):
    with jax.enable_x64(True):
        ramp = Ramp(kind="ramp", value=4.0, duration=2.0).build(tmp_path)
        rate, acceleration = jax.jit(jax.grad(ramp)), jax.jit(jax.grad(jax.grad(ramp)))
        for end in (1e-9, 2.0 - 1e-9):
            assert abs(rate(end)) < 1e-8
            assert abs(acceleration(end)) < 1e-7
        values = np.asarray(jax.jit(jax.vmap(ramp))(jnp.asarray(TIMES)))
    assert (np.diff(values) >= 0.0).all()
    assert (values[TIMES >= 2.0] == 4.0).all()
    assert ramp(1.0) == pytest.approx(2.0)


def test_spin_up_turns_by_half_of_the_final_speed_times_its_duration(tmp_path):
    law = SpinUp(kind="spin-up", speed=2.0, duration=4.0)
    values = sampled(law, tmp_path)
    assert values[TIMES == 4.0] == pytest.approx(2.0 * 4.0 / 2)
    assert np.diff(values)[-1] == pytest.approx(2.0 * (TIMES[1] - TIMES[0]))


def test_table_passes_through_its_rows_with_a_continuous_second_derivative(tmp_path):
    rows = np.column_stack([np.linspace(0.0, 5.0, 11), np.sin(np.linspace(0.0, 5.0, 11))])
    np.savetxt(tmp_path / "law.csv", rows, delimiter=",", header="time,value")
    with jax.enable_x64(True):
        law = jax.jit(TableLaw(kind="table", file="law.csv").build(tmp_path).__call__)
        np.testing.assert_allclose([law(t) for t in rows[:, 0]], rows[:, 1], atol=1e-12)
        second = jax.jit(jax.grad(jax.grad(law)))
        for t in rows[1:-1, 0]:
            assert float(second(t - 1e-9)) == pytest.approx(float(second(t + 1e-9)), abs=1e-6)
        assert float(law(9.0)) == pytest.approx(rows[-1, 1])


@pytest.mark.parametrize(
    ("table", "law"),
    [
        (Constant(kind="constant", value=3.0), machine.Constant(3.0)),
        (Ramp(kind="ramp", value=4.0, duration=2.0), machine.Ramp(4.0, 2.0)),
        (Sine(kind="sine", amplitude=2.0, frequency_hz=0.5), machine.Sine(2.0, 0.5)),
        (SpinUp(kind="spin-up", speed=2.0, duration=4.0), machine.SpinUp(2.0, 4.0)),
        (TableLaw(kind="table", file="law.csv"), machine.Spline([0.0, 1.0, 3.0], [0.0, 1.0, 3.5])),
    ],
)
def test_a_table_builds_what_a_script_would_write(tmp_path, table, law):
    (tmp_path / "law.csv").write_text("0,0\n1,1\n3,3.5\n")
    built = table.build(tmp_path)
    assert type(built) is type(law)
    own, expected = jax.tree.leaves(built), jax.tree.leaves(law)
    assert expected
    for leaf, other in zip(own, expected, strict=True):
        np.testing.assert_array_equal(leaf, other)


@pytest.mark.slow
def test_a_load_that_jumps_does_not_swing(tmp_path):
    """A step of 1 kN within a millisecond: between its rows the force stays between them, as in a script."""
    rows = "0,0\n0.5,0\n0.501,1000\n1,1000\n"
    (tmp_path / "step.csv").write_text(rows)
    load = Force.model_validate(
        {
            "kind": "force",
            "at": "bar.tip",
            "vector": [0.0, 0.0, 1.0],
            "law": {"kind": "table", "file": "step.csv"},
        }
    ).build(tmp_path, lambda _: Place("bar", "tip"))
    force = np.array([load.law(t)[2] for t in np.linspace(0.0, 1.0, 2001)])
    assert force.min() == 0.0
    assert force.max() == 1000.0
    assert float(load.law(0.5005)[2]) == pytest.approx(500.0)
    assert (load.law.begin, load.law.end) == (0.0, 1.0)


def test_a_motion_that_jumps_is_refused_with_its_row(tmp_path):
    """A spline through a step of one radian would swing by a tenth of it."""
    (tmp_path / "step.csv").write_text("0,0\n0.5,0\n0.501,1\n1,1\n")
    with pytest.raises(ImportFormatError, match=r"between rows \d and \d .* a motion must be smooth"):
        TableLaw(kind="table", file="step.csv").build(tmp_path)


@pytest.mark.parametrize("rows_per_period", [16, 50])
def test_a_sampled_sine_is_a_motion(tmp_path, rows_per_period):
    times = np.arange(2 * rows_per_period + 1) / rows_per_period
    rows = np.column_stack([times, np.sin(2 * np.pi * times + 0.1)])
    np.savetxt(tmp_path / "sine.csv", rows, delimiter=",")
    law = TableLaw(kind="table", file="sine.csv").build(tmp_path)
    assert float(law(0.8)) == pytest.approx(np.sin(2 * np.pi * 0.8 + 0.1), abs=2e-3)

"""Curves show what is there: no noise that fills a panel, no place that hides another one's way."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from supple.integrate import Solution, Statistics
from supple.linearization import CampbellDiagram, CriticalSpeed
from supple.machine import GROUND, At, Fixed
from supple.quantities import TrackedMotion
from supple.units import SI
from supple.viz import (
    Panel,
    Series,
    campbell_plot,
    plot_campbell,
    plot_time_history,
    run_curves,
    time_history,
)
from supple.viz.campbell_plot import _apart
from supple.viz.run_curves import draw_joint_forces, draw_tracked

T = np.linspace(0.0, 1.0, 101)


@pytest.fixture
def figure(monkeypatch):
    """The figure that is drawn, instead of its file."""
    drawn = SimpleNamespace()

    def take(own, path):
        own.draw_without_rendering()
        drawn.axes = [axes for axes in own.axes if axes.axison]
        return path

    monkeypatch.setattr(time_history, "save_figure", take)
    monkeypatch.setattr(campbell_plot, "save_figure", take)
    return drawn


def heights(axes):
    return [line.get_ydata() for line in axes.get_lines()]


# --- noise


def test_noise_beside_large_values_is_zero_and_small_values_are_not(figure, tmp_path):
    large, small, noise = np.sin(9 * T), 2e-6 * np.sin(9 * T), 9e-7 * np.sin(9 * T)
    panels = [Panel(name, [Series(name, T, each)], 1.0) for name, each in (("a", small), ("b", noise))]
    plot_time_history(tmp_path / "a.png", [Panel("c", [Series("c", T, large)], 1.0), *panels])
    _, seen, unseen = (heights(axes)[0] for axes in figure.axes)
    assert np.abs(seen).max() == pytest.approx(2e-6, rel=1e-2)
    assert not unseen.any()


def test_noise_on_a_constant_does_not_fill_its_panel(figure, tmp_path):
    constant = 14.166 + 1e-6 * np.sin(50 * T)
    plot_time_history(tmp_path / "a.png", [Panel("force (N)", [Series("force", T, constant)])])
    low, high = figure.axes[0].get_ylim()
    assert low < 14.166 < high
    assert np.ptp(constant) < 0.02 * (high - low)


def test_gaps_and_infinities_do_not_count_as_large(figure, tmp_path):
    values = np.where(T > 0.5, np.nan, 1e-3 * T)
    values[-1] = np.inf
    plot_time_history(tmp_path / "a.png", [Panel("a", [Series("a", T, values)])])
    assert np.nanmax(heights(figure.axes[0])[0][:-1]) == pytest.approx(5e-4)


# --- places


def place(x, y=0.0, deflection=None):
    position = np.stack([x + 0 * T, y + 0 * T, 0 * T], axis=1)
    bent = np.zeros_like(position) if deflection is None else np.stack([deflection, 0 * T, 0 * T], axis=1)
    return TrackedMotion(position, "root", bent, is_elastic=deflection is not None)


@pytest.mark.slow
def test_places_far_apart_have_axes_of_their_own(figure, tmp_path):
    tail, tip = place(0.01 * np.sin(T)), place(60.0 + 0.02 * np.sin(T))
    draw_tracked(tmp_path / "a.png", {"bar.tail": tail, "bar.tip": tip}, T, SI)
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "x, global (m)",
        "x, global (m)",
        "y, global (m)",
        "z, global (m)",
    ]
    spans = [np.ptp(axes.get_ylim()) for axes in figure.axes[:2]]
    assert max(spans) < 0.03
    assert [len(axes.get_lines()) for axes in figure.axes] == [1, 1, 2, 2]
    assert figure.axes[-1].get_xlabel() == "time (s)"


@pytest.mark.slow
def test_places_that_move_far_share_their_axes(figure, tmp_path):
    near, far = place(np.sin(9 * T)), place(4.0 + np.sin(9 * T))
    draw_tracked(tmp_path / "a.png", {"near": near, "far": far}, T, SI)
    assert [len(axes.get_lines()) for axes in figure.axes] == [2, 2, 2]


@pytest.mark.slow
def test_deflections_stand_beside_the_places_that_they_are_of(figure, tmp_path):
    bent, rigid = place(0.01 * T, deflection=1e-3 * T), place(60.0 + 0.02 * T)
    draw_tracked(tmp_path / "a.png", {"tip": bent, "hub": rigid}, T, SI)
    found = [(axes.get_ylabel(), axes.get_lines()[0].get_label()) for axes in figure.axes]
    assert found[:3] == [("x, global (m)", "tip"), ("deflection x (m)", "tip"), ("x, global (m)", "hub")]


def test_places_of_noise_about_a_still_axis_are_one_group(figure, tmp_path):
    places = {str(i): place(np.sin(9 * T), 1e-9 * (i + 1e-3 * np.sin(T))) for i in range(3)}
    draw_tracked(tmp_path / "a.png", places, T, SI)
    assert len(figure.axes) == 3
    assert not any(each.any() for each in heights(figure.axes[1]))


# --- joints


def test_forces_of_joints_name_their_axes_and_show_no_noise(figure, tmp_path, monkeypatch):
    loads = {"clamp": {"force": np.stack([37.0 * np.sin(T), 3e-5 * np.sin(T), 2.0 + 0 * T], axis=1)}}
    monkeypatch.setattr(run_curves, "joint_loads", lambda *_: loads)
    joint = Fixed(name="clamp", first=GROUND, second=At("rod", "root"))
    system = SimpleNamespace(joints=(joint,))
    draw_joint_forces(tmp_path / "a.png", system, Solution(T, {}, {}, Statistics()), SI)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["force, joint x (N)", "force, joint y (N)", "force, joint z (N)"]
    assert not heights(figure.axes[1])[0].any()
    assert heights(figure.axes[2])[0][0] == 2.0


# --- Campbell diagram


def diagram(rates, frequencies, critical=(), **given):
    """Modes of these frequencies, rad per unit of time, with these critical speeds."""
    kind = type("Diagram", (CampbellDiagram,), {"critical_speeds": [CriticalSpeed(c, 1) for c in critical]})
    frequencies = np.array(frequencies)
    return kind(np.array(rates), 1j * frequencies, np.ones_like(frequencies[1:]), **given)


def test_names_of_close_modes_do_not_cover_each_other():
    placed = _apart(np.array([5.0, 1.0, 5.01, 9.99, 10.0]), 10.0)
    in_order = placed[[1, 0, 2, 3, 4]]
    assert np.diff(in_order).min() >= 0.32 - 1e-12
    assert placed[1] == 1.0
    assert placed.max() <= 10.0


def test_a_campbell_diagram_is_in_rpm_and_names_its_lines(figure, tmp_path):
    followed = diagram(
        [0.0, np.pi],
        2 * np.pi * np.array([[0.7, 1.4, np.nan], [0.8, np.nan, np.nan]]),
        critical=[2.0],
        axes="turning with the machine",
        sense=np.zeros((2, 3), dtype=int),
        in_space=np.full((2, 3), np.nan),
        names=("flap 1", "edge 1", "lost"),
    )
    plot_campbell(tmp_path / "a.png", followed, units=SI)
    (axes,) = figure.axes
    words = [text.get_text() for text in axes.texts]
    assert {"flap 1", "edge 1", "1P", "2P", "3P", "4P", "critical, 19.1 rpm"} <= set(words)
    assert axes.get_xlabel() == "speed (rpm)"
    assert axes.get_ylabel() == "frequency in axes turning with the machine (Hz)"
    assert axes.get_lines()[0].get_xdata() == pytest.approx([0.0, 30.0])


def test_whirls_are_drawn_as_they_are_seen_in_space_too(figure, tmp_path):
    followed = diagram(
        [0.0, 8.0],
        [[5.0, 9.0], [3.0, 9.0]],
        critical=[5.0],
        in_space=np.array([[5.0, 9.0], [5.0, np.nan]]),
        sense=np.array([[0, 0], [1, 0]]),
        axes="turning with the machine",
        names=("forward whirl 1", "stretch"),
    )
    plot_campbell(tmp_path / "a.png", followed, units=SI)
    in_space, turning = figure.axes
    assert in_space.get_ylabel() == "whirl frequency in space (Hz)"
    assert in_space.get_lines()[4].get_ydata() == pytest.approx(np.array([5.0, 5.0]) / (2 * np.pi))
    assert "stretch" not in [text.get_text() for text in in_space.texts]
    assert turning.get_lines()[4].get_ydata() == pytest.approx(np.array([5.0, 3.0]) / (2 * np.pi))


@pytest.mark.parametrize("rates", [(-2.0, 0.0, 2.0), (2.0, 1.0, 0.0), (-1.5, 0.5)])
def test_names_of_multiples_are_on_their_lines(figure, tmp_path, rates):
    followed = diagram(
        rates,
        np.full((len(rates), 1), 10.0),
        axes="turning",
        sense=np.zeros((len(rates), 1), dtype=int),
        in_space=np.full((len(rates), 1), np.nan),
        names=("flap",),
    )
    plot_campbell(tmp_path / "a.png", followed, units=SI)
    (axes,) = figure.axes
    assert axes.get_lines()[-1].get_zorder() > axes.texts[0].get_zorder()  # no name covers a mode
    for text, line in zip(axes.texts[:4], axes.get_lines(), strict=False):
        (x, y), ascending = text.xy, np.argsort(line.get_xdata())
        assert y == pytest.approx(np.interp(x, line.get_xdata()[ascending], line.get_ydata()[ascending]))
        assert 0.0 < y < axes.get_ylim()[1]

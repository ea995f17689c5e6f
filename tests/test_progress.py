"""Bars of long work in Python."""

from __future__ import annotations

import inspect
import time

import pytest
from rich.console import Console

import supple as sp
from supple import progress
from supple.progress import by_fraction, by_step, progress_bar, with_progress_bar


@pytest.fixture
def watched(monkeypatch):
    monkeypatch.setattr(progress, "_is_watched", lambda: True)
    monkeypatch.setattr(progress, "PATIENCE", 0.05)
    as_a_terminal = Console(stderr=True, force_terminal=True)
    monkeypatch.setattr("supple.terminal.error_console", as_a_terminal)


@with_progress_bar("marching", by_fraction)
def march(*, seconds, progress=None):
    """Work of two halves."""
    for share in (0.5, 1.0):
        time.sleep(seconds / 2)
        if progress is not None:
            progress(share)
    return "done"


def test_work_that_is_soon_done_shows_nothing(watched, capsys):
    assert march(seconds=0.0) == "done"
    time.sleep(0.1)
    assert capsys.readouterr().err == ""


def test_longer_work_shows_its_title(watched, capsys):
    assert march(seconds=0.4) == "done"
    assert "marching" in capsys.readouterr().err


def test_steps_are_named(watched, capsys):
    with progress_bar("correcting") as share:
        assert share is not None
        time.sleep(0.2)
        by_step(share)("second round", 0.5)
        time.sleep(0.2)
    assert "correcting: second round" in capsys.readouterr().err


@pytest.mark.slow
def test_a_notebook_shows_a_line_of_html_without_widgets(watched, monkeypatch):
    pytest.importorskip("IPython")
    shown = []
    monkeypatch.setattr(progress, "_is_notebook", lambda: True)
    monkeypatch.setattr(
        "IPython.display.DisplayHandle.display", lambda _, data, **_options: shown.append(data)
    )
    monkeypatch.setattr(
        "IPython.display.DisplayHandle.update", lambda _, data, **_options: shown.append(data)
    )
    march(seconds=0.8)
    assert shown[1]["text/html"] == "<progress></progress> marching"
    assert shown[2]["text/html"] == '<progress value="0.500"></progress> marching 50 %'
    assert shown[-1] == {"text/plain": "", "text/html": ""}


def test_work_within_other_work_has_no_bar(watched):
    with progress_bar("outer") as outer, progress_bar("inner") as inner:
        assert outer is not None
        assert inner is None
    with progress_bar("next") as share:
        assert share is not None


def test_one_setting_switches_bars_off(watched, capsys):
    sp.show_progress(False)
    try:
        march(seconds=0.3)
    finally:
        sp.show_progress()
    assert capsys.readouterr().err == ""


def test_nothing_is_shown_where_nobody_watches(monkeypatch, capsys):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    march(seconds=0.2)
    assert capsys.readouterr().err == ""


def test_a_caller_with_a_bar_of_its_own_gets_the_shares(watched, capsys):
    shares = []
    march(seconds=0.3, progress=shares.append)
    assert shares == [0.5, 1.0]
    assert capsys.readouterr().err == ""


def test_failing_work_takes_its_bar_away(watched):
    with pytest.raises(RuntimeError), progress_bar("failing"):
        raise RuntimeError
    with progress_bar("next") as share:
        assert share is not None


def test_decorated_functions_keep_their_signature():
    assert "overwrite" in inspect.signature(sp.simulate).parameters

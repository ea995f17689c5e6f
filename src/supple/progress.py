"""Progress of computations: a bar after two seconds in a terminal or notebook, a log record at the end."""

from __future__ import annotations

import logging
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from html import escape
from threading import Lock, Timer
from time import monotonic, perf_counter
from typing import ParamSpec, Protocol, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

LOGGER = logging.getLogger("supple")
PATIENCE = 2.0
"""s, time from the start of a computation until its bar appears."""
BETWEEN = 0.2
"""s, least time between two updates of a bar in a notebook."""


class Share(Protocol):
    """Receives the finished fraction, 0 to 1, and for work in several steps the name of the step."""

    def __call__(self, fraction: float, step: str = "", /) -> None:
        """Report a fraction of a step."""
        ...


Adapter = Callable[[Share], Callable[..., None]]
_switch = {"on": True}
_outermost: ContextVar[bool] = ContextVar("outermost", default=True)


def show_progress(shown: bool = True) -> None:
    """Switch the bars of this process on (the default) or off."""
    _switch["on"] = shown


def by_fraction(share: Share) -> Callable[[float], None]:
    """Adapter for work that reports its finished fraction."""
    return share


def by_step(share: Share) -> Callable[[str, float], None]:
    """Adapter for work that reports steps and the finished fraction of each."""
    return lambda step, fraction: share(fraction, step)


def with_progress_bar(
    title: str, adapter: Adapter | None = None
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorator of a long computation: it shows a bar, and logs the title and the duration at the end.

    adapter : converts the `Share` of the bar to the argument `progress` of the decorated function; None: the
        bar shows no fraction

    No bar is shown if the caller passes `progress`.
    """

    def decorate(work: Callable[P, T]) -> Callable[P, T]:
        @wraps(work)
        def logged(*args: P.args, **kwargs: P.kwargs) -> T:
            began = perf_counter()
            found = watched(*args, **kwargs)
            LOGGER.info("%s: %.3g s", title, perf_counter() - began)
            return found

        def watched(*args: P.args, **kwargs: P.kwargs) -> T:
            """Do the work with a bar, unless the caller receives its progress."""
            if kwargs.get("progress") is not None:
                return work(*args, **kwargs)
            with progress_bar(title) as share:
                if share is None or adapter is None:
                    return work(*args, **kwargs)
                reporting: Callable[..., T] = work
                return reporting(*args, **{**kwargs, "progress": adapter(share)})

        return logged

    return decorate


@contextmanager
def progress_bar(title: str) -> Iterator[Share | None]:
    """Context with a bar; yields its `Share`, or None if no bar is shown.

    No bar is shown if bars are switched off, without a terminal or notebook, or inside another such context.
    """
    if not (_switch["on"] and _outermost.get() and _is_watched()):
        yield None
        return
    bar, token = _Bar(title), _outermost.set(False)
    try:
        yield bar.share
    finally:
        _outermost.reset(token)
        bar.stop()


def _is_watched() -> bool:
    return _is_notebook() or sys.stderr.isatty()


def _is_notebook() -> bool:
    """Whether this process is a notebook kernel; an import of IPython alone is not enough."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


class _TerminalLine:
    """Line on standard error."""

    def __init__(self, title: str) -> None:
        # Imported here: short computations, and scripts without a terminal, do not need this module.
        from supple.terminal import error_console, progress_bars

        self._bars = progress_bars(error_console, transient=True)
        self._task = self._bars.add_task(title, total=None)
        self._bars.start()

    def update(self, text: str, fraction: float | None) -> None:
        """Show the description and the fraction."""
        total = None if fraction is None else 1.0
        self._bars.update(self._task, description=text, total=total, completed=fraction or 0.0)

    def stop(self) -> None:
        """Remove the line."""
        self._bars.stop()


class _NotebookLine:
    """Line in the output of a cell, as plain HTML: the bars of rich need ipywidgets there."""

    def __init__(self, _title: str) -> None:
        from IPython.display import DisplayHandle

        self._handle = DisplayHandle()
        self._handle.display({"text/plain": ""}, raw=True)
        self._shown_at = -math.inf

    def update(self, text: str, fraction: float | None) -> None:
        """Show the description and the fraction, unless the last update is too recent."""
        if monotonic() - self._shown_at < BETWEEN:
            return
        self._shown_at = monotonic()
        value = "" if fraction is None else f' value="{fraction:.3f}"'
        share = "" if fraction is None else f" {100 * fraction:.0f} %"
        html = f"<progress{value}></progress> {escape(text)}{share}"
        self._handle.update({"text/plain": f"{text}{share}", "text/html": html}, raw=True)

    def stop(self) -> None:
        """Empty the line."""
        self._handle.update({"text/plain": "", "text/html": ""}, raw=True)


class _Bar:
    """A line that disappears at the end of the work."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._step = ""
        self._fraction: float | None = None
        self._over = False
        self._line: _TerminalLine | _NotebookLine | None = None
        self._lock = Lock()
        self._timer = Timer(PATIENCE, self._appear)
        self._timer.daemon = True
        self._timer.start()

    def share(self, fraction: float, step: str = "", /) -> None:
        """Report a fraction of a step."""
        with self._lock:
            self._fraction, self._step = fraction, step
            self._update()

    def stop(self) -> None:
        """Remove the bar after the work ends or fails."""
        self._timer.cancel()
        with self._lock:
            self._over = True
            if self._line is not None:
                self._line.stop()

    def _appear(self) -> None:
        with self._lock:
            if self._over:
                return
            self._line = _NotebookLine(self._title) if _is_notebook() else _TerminalLine(self._title)
            self._update()

    def _update(self) -> None:
        if self._line is None or self._over:
            return
        described = f"{self._title}: {self._step}" if self._step else self._title
        self._line.update(described, self._fraction)

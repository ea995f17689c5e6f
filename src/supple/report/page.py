"""The page: one HTML file that needs no network, with its styles, scripts, tables and data."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from pathlib import Path

from supple.report.charts import Chart
from supple.report.moving_machine import MovingMachine
from supple.report.packed_arrays import PackedArrays
from supple.report.scene_data import chart_data, scene_data
from supple.results.run_tables import TextTable
from supple.storage.atomic_write import replacing
from supple.units import UNNAMED, UnitSystem


@dataclass(frozen=True)
class Assets:
    """Files of a kind of page.

    template : name of the HTML file;   styles : names of CSS files
    scripts : names of JavaScript files, in the order of their dependencies
    """

    template: str
    styles: Sequence[str]
    scripts: Sequence[str]


_PLAYER = Assets(
    "page.html",
    ("page",),
    ("arrays", "colours", "bodies", "marks", "views", "picking", "curves", "player", "main"),
)


@dataclass(frozen=True)
class PageSection:
    """A heading with lines of text, tables, and verbatim texts, such as a case file, by name."""

    title: str
    lines: Sequence[str] = ()
    tables: Sequence[TextTable] = ()
    texts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Clip:
    """A part of a machine's motion that is played separately, such as one mode.

    first : index of the first time;   number : number of times
    repeats : whether the last time is followed by the first
    """

    name: str
    first: int
    number: int
    note: str = ""
    repeats: bool = False


@dataclass(frozen=True, eq=False)
class Page:
    """Content of a page.

    sections : in their order;   machine : None if there is nothing to draw
    clips : parts of the motion of the machine; by default the whole motion
    """

    title: str
    sections: Sequence[PageSection]
    machine: MovingMachine | None = None
    clips: Sequence[Clip] = ()
    charts: Sequence[Chart] = ()
    units: UnitSystem = UNNAMED


def write_page(path: Path | str, page: Page) -> Path:
    """Write the text of a page; ResultFileError where the file cannot be written."""
    return write_text(path, page_text(page))


def write_text(path: Path | str, text: str) -> Path:
    """Write a text file atomically; ResultFileError where the file cannot be written."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return Path(path)


def page_text(page: Page) -> str:
    """A page as HTML; its content policy forbids all requests, and scripts that are not part of the page."""
    arrays = PackedArrays()
    head = {
        "time": page.units.time,
        "length": page.units.length,
        "force": page.units.force,
        "moment": page.units.moment,
        "secondsPerTime": page.units.in_si(time=1),
        "scene": None if page.machine is None else scene_data(page.machine, arrays),
        "clips": [vars(clip) for clip in page.clips],
        "charts": chart_data(page.charts, arrays),
    }
    return html_text(_PLAYER, page.title, page.sections, head, arrays)


def html_text(
    assets: Assets,
    title: str,
    sections: Sequence[PageSection],
    head: Mapping[str, object],
    arrays: PackedArrays,
) -> str:
    """One HTML file of sections and data, displayed by its scripts.

    head : JSON data for the scripts;   arrays : the arrays whose positions are in the head
    """
    libraries = _source("libraries.js")
    # Joined in the scope of one function.
    own = "\n".join(_source(f"{name}.js") for name in assets.scripts)
    scripts = f'(() => {{\n"use strict";\n{own}}})();\n'
    styles = "".join(_source(f"{name}.css") for name in ("libraries", *assets.styles))
    parts = {
        "policy": _policy([libraries, scripts], styles),
        "title": escape(title),
        "styles": styles,
        "sections": "\n".join(_section(section) for section in sections),
        # "</script>" in a text would end the data: "<" is always escaped.
        "head": json.dumps(head, allow_nan=False).replace("<", "\\u003c"),
        "data": arrays.text(),
        "libraries": libraries,
        "scripts": scripts,
    }
    return re.sub(r"@([a-z]+)@", lambda found: parts[found.group(1)], _source(assets.template))


def _source(name: str) -> str:
    return files("supple.report").joinpath("assets", name).read_text(encoding="utf-8")


def _policy(scripts: Sequence[str], styles: str) -> str:
    """Content policy: no requests, and only the given scripts, whatever the texts of a case contain."""
    allowed = " ".join(_hash(script) for script in scripts)
    return (
        f"default-src 'none'; script-src {allowed}; style-src {_hash(styles)}; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def _section(section: PageSection) -> str:
    parts = [f"<section><h2>{escape(section.title)}</h2>"]
    parts += [f"<p>{escape(line)}</p>" for line in section.lines]
    parts += [_table(table) for table in section.tables if table.rows]
    parts += [
        f"<details><summary>{escape(name)}</summary><pre>{escape(text)}</pre></details>"
        for name, text in section.texts.items()
    ]
    return "\n".join([*parts, "</section>"])


def _table(table: TextTable) -> str:
    def row(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "\n".join(row(cells, "td") for cells in table.rows)
    return (
        f"<div class=table><table><caption>{escape(table.title)}</caption>"
        f"<thead>{row(table.heads, 'th')}</thead><tbody>\n{body}\n</tbody></table></div>"
    )

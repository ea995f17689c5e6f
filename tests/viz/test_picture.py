"""Paths of pictures in a notebook."""

from __future__ import annotations

import pickle
from base64 import b64decode
from pathlib import Path

import pytest

from supple.mesh import skin_of, strip
from supple.viz import plot_mesh
from supple.viz.style import Picture


def test_a_notebook_shows_a_picture_where_a_mesh_is_drawn(tmp_path):
    mesh = strip(1.0, 0.1, 2, 2)
    drawn = plot_mesh(tmp_path / "mesh.png", mesh.nodes, skin_of(mesh))
    content = drawn._repr_html_().split("base64,")[1].split('"')[0]
    assert b64decode(content) == (tmp_path / "mesh.png").read_bytes()
    assert drawn == tmp_path / "mesh.png"


@pytest.mark.parametrize("name", ["mesh.pdf", "not there.png"])
def test_what_a_page_cannot_show_is_a_path(tmp_path, name):
    assert Picture(tmp_path / name)._repr_html_() is None


def test_a_picture_is_a_path(tmp_path):
    picture = Picture(tmp_path / "a.png")
    assert isinstance(picture, Path)
    assert pickle.loads(pickle.dumps(picture)) == picture
    assert picture.with_suffix(".svg").name == "a.svg"

"""Assemble the pages of the site: docs, files that they link to, case-file reference, API by folder, gallery.

    python tools/site/assemble.py build/site build/gallery

The pages in `docs` are also read in the repository; some of their links point to files outside `docs`. These
files are copied below `repository/`, and the links are changed to the copies. Links to folders become text.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from case_reference import case_reference
from gallery import write_pages

ROOT = Path(__file__).parents[2]
_LINK = re.compile(r"\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s#]+)(#[^()\s]*)?\)")


def assemble(folder: Path, gallery: Path) -> None:
    """Write the source tree of the site into a new `folder`; `gallery` has the results of the examples."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder, ignore=shutil.ignore_patterns("*.md"))
    tree = _Tree(folder)
    tree.copied(ROOT / "README.md")
    for page in sorted((ROOT / "docs").rglob("*.md")):
        tree.copied(page)
    (folder / "reference").mkdir()
    (folder / "reference" / "case_file.md").write_text(case_reference(), "utf-8")
    _api(folder / "api")
    write_pages(gallery, folder / "gallery")


@dataclass(frozen=True)
class _Tree:
    folder: Path

    def place(self, path: Path) -> Path:
        """Path of a file of the repository in the site's tree."""
        if path == ROOT / "README.md":
            return self.folder / "index.md"
        if path == ROOT / "docs" / "README.md":
            return self.folder / "contents.md"
        if path.is_relative_to(ROOT / "docs"):
            return self.folder / path.relative_to(ROOT / "docs")
        return self.folder / "repository" / path.relative_to(ROOT)

    def copied(self, path: Path) -> Path:
        """The copy of a file, created if it does not exist; links of a page are changed as well."""
        copy = self.place(path)
        if not copy.exists():
            copy.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".md":
                # Listed first, so that pages with links to each other do not recurse without end.
                copy.touch()
                copy.write_text(self._with_links(path.read_text("utf-8"), path), "utf-8")
            else:
                shutil.copy(path, copy)
        return copy

    def _with_links(self, text: str, page: Path) -> str:
        """The text of a page with its links changed to the copies of the linked files."""
        here = self.place(page).parent

        def linked(found: re.Match[str]) -> str:
            words, target, anchor = found.groups()
            path = (page.parent / target).resolve()
            if "://" in target:
                return found.group()
            if path.is_dir():
                return words
            return f"[{words}]({os.path.relpath(self.copied(path), here)}{anchor or ''})"

        return _LINK.sub(linked, text)


_HIDDEN = {"cli", "data"}


def _api(folder: Path) -> None:
    """One page for each folder of the package, from its docstrings."""
    folder.mkdir()
    package = ROOT / "src" / "supple"
    names = [path.parent.name for path in sorted(package.glob("*/__init__.py"))]
    listed = [name for name in names if name not in _HIDDEN]
    for name in listed:
        (folder / f"{name}.md").write_text(f"# supple.{name}\n\n::: supple.{name}\n", "utf-8")
    rows = "".join(f"- [`supple.{name}`]({name}.md)\n" for name in listed)
    front = "What most scripts need is in `import supple as sp`; each name is described in its folder.\n\n"
    (folder / "index.md").write_text(f"# Python interface, by folder\n\n{front}{rows}", "utf-8")


if __name__ == "__main__":
    assemble(Path(sys.argv[1]), Path(sys.argv[2]))

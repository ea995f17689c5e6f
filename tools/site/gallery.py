"""Run the examples and make a page of each for the site: problem, pictures, report, program.

    python tools/site/gallery.py build/gallery

An example is a program that asserts its expected result, or a case file. Results are stored: an example runs
again only if its file or the package is newer. If an example fails, the gallery ends with its output.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from supple.cases import command_of_example, example_text

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
_MODES = {"blade_campbell"}
"""Cases for `supple modes --rates`, with the rates stated in their header."""


def run_all(folder: Path) -> None:
    """Run examples that are not up to date, each in a folder of its own."""
    sources = max(path.stat().st_mtime for path in (ROOT / "src" / "supple").rglob("*.py"))
    # `python` and `supple` are those of this environment.
    here = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for example in examples():
        place = folder / example.stem
        done = place / "output.txt"
        if done.exists() and done.stat().st_mtime > max(sources, example.stat().st_mtime):
            continue
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        print(f"running {example.name}", flush=True)
        ran = subprocess.run(
            _command(example), cwd=place, env=here, capture_output=True, text=True, check=False
        )
        if ran.returncode:
            raise SystemExit(f"{example.name} failed:\n{ran.stdout[-2000:]}{ran.stderr[-4000:]}")
        done.write_text(ran.stdout, "utf-8")


def examples() -> list[Path]:
    """Programs and case files; of two that share a name, the program."""
    programs = sorted(EXAMPLES.glob("*.py"))
    named = {path.stem for path in programs}
    cases = [path for path in sorted(EXAMPLES.glob("*.toml")) if path.stem not in named]
    return sorted([*programs, *cases], key=lambda path: path.stem)


def write_pages(gallery: Path, folder: Path) -> None:
    """Write the pages of the examples that ran in `gallery` into `folder` of the site's tree."""
    folder.mkdir(parents=True)
    rows = []
    for example in examples():
        place = gallery / example.stem
        if not (place / "output.txt").exists():  # not run, or not to its end
            continue
        title, text = _described(example)
        page = f"{example.stem}.md"
        pictures = _copied(place, folder / example.stem, "*.png")
        pages = _copied(place, folder / example.stem, "*.html")
        shown = "".join(f"![{Path(name).stem}]({example.stem}/{name})\n\n" for name in pictures)
        # A page of the site is in a folder named after it.
        shown += "".join(
            f'<iframe src="./{name}" title="report" width="100%" height="720"></iframe>\n\n' for name in pages
        )
        kind = "python" if example.suffix == ".py" else "toml"
        printed = (place / "output.txt").read_text("utf-8").strip("\n")
        output = f"It prints\n\n```text\n{printed}\n```\n\n" if printed else ""
        code = example.read_text("utf-8")
        (folder / page).write_text(
            f"# {title}\n\n{text}\n\n{shown}{output}`examples/{example.name}`:\n\n```{kind}\n{code}```\n",
            "utf-8",
        )
        first = (
            f"[![{title}]({example.stem}/{pictures[0]}){{ width=240 }}]({example.stem}.md)<br>"
            if pictures
            else ""
        )
        rows.append(f"| {first} | [{title}]({page}) |")
    front = "Each example shows one idea. It states the expected result and fails if the result differs."
    table = "\n".join(["| | |", "| --- | --- |", *rows])
    (folder / "index.md").write_text(f"# Gallery\n\n{front}\n\n{table}\n", "utf-8")


def _command(example: Path) -> list[str]:
    if example.stem in _MODES:
        return ["supple", "modes", str(example), "-o", ".", "--rates", "0:2.5:11"]
    results = [] if example.suffix == ".py" else ["-o", "."]
    return [*shlex.split(command_of_example(example)), *results]


def _described(example: Path) -> tuple[str, str]:
    """Title and text."""
    title, _, text = example_text(example).partition("\n")
    return title.strip().rstrip("."), text.strip()


def _copied(place: Path, target: Path, pattern: str) -> list[str]:
    target.mkdir(exist_ok=True)
    found = sorted(place.glob(pattern))
    for path in found:
        shutil.copy(path, target / path.name)
    return [path.name for path in found]


if __name__ == "__main__":
    run_all(Path(sys.argv[1]))

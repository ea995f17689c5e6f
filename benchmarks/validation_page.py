"""The table of docs/validation.md from the report of `supple benchmark validation`.

supple benchmark validation --json benchmarks/results/validation.json
python benchmarks/validation_page.py
"""

from __future__ import annotations

import json
from pathlib import Path

from supple_benchmarks.validation.report import with_table

REPORT = Path(__file__).parent / "results" / "validation.json"
PAGE = Path(__file__).parents[1] / "docs" / "validation.md"


def main() -> None:
    report = json.loads(REPORT.read_text(encoding="utf-8"))
    PAGE.write_text(with_table(PAGE.read_text(encoding="utf-8"), report["cases"]), encoding="utf-8")


if __name__ == "__main__":
    main()

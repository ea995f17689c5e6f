"""Build the libraries of linear FMUs for all platforms into the package; `make package` runs this first.

Needs the cross-compiler of `supple[fmu]`. Removes libraries of earlier sources.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from supple.export.fmu.platforms import EVERY_PLATFORM, compilers_of
from supple.export.fmu.prebuilt import FOLDER, prebuilt_path
from supple.export.fmu.write_fmu import compile_library, linear_sources


def main() -> None:
    """Write one library for each version of FMI and platform."""
    folder = Path(str(FOLDER))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for fmi in (2, 3):
        sources = linear_sources(fmi)
        for compiler in compilers_of(EVERY_PLATFORM, fmi):
            library = compile_library(compiler, sources)
            path = folder / prebuilt_path(sources, compiler.platform, fmi)
            path.write_bytes(library)
            print(f"{path.name}: {len(library) // 1000} kB")


if __name__ == "__main__":
    main()

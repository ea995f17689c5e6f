"""The part of `against_feniax.py` that runs in FENIAX's interpreter, without supple.

    python feniax_run.py FOLDER

FOLDER holds Ka.npy, Ma.npy, structuralGrid and case.json. The script compiles and runs the case and writes a
line with the path of the tip and the versions. For every line read from standard input it repeats the run and
writes a line with the time. FENIAX (licence GPL-3.0) must be installed; no code of it is contained here.
"""

from __future__ import annotations

import json
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter, process_time
from typing import Any


def main(folder: Path) -> None:
    output, sys.stdout = sys.stdout, sys.stderr  # FENIAX prints on the way
    import feniax.feniax_main
    import jax

    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    driver = feniax.feniax_main.main(input_dict=settings(folder, case), return_driver=True)
    (system,) = driver.systems.values()
    found = {"tip": system.sol.data.dynamicsystem_sys1.ra[:: case["every"], :, -1].tolist()}
    used = {name: version_of(name) for name in ("FENIAX", "jax", "jaxlib", "numpy")}
    write_line(output, found | {"versions": used | {"python": sys.version.split()[0]}})

    own = system.settings
    for _ in sys.stdin:
        began, began_wall = process_time(), perf_counter()
        found = system.eqsolver(
            system.dFq,
            system.args1,
            own.solver_settings,
            q0=system.q0,
            t0=own.t0,
            t1=own.t1,
            tn=own.tn,
            dt=own.dt,
            t=own.t,
        )
        jax.block_until_ready(found)
        write_line(output, {"processor": process_time() - began, "wall": perf_counter() - began_wall})


def settings(folder: Path, case: dict[str, Any]) -> dict[str, Any]:
    """A clamped line under a constant follower force at its last station, by the Runge-Kutta rule."""
    points = [[case["stations"] - 1, axis] for axis in range(3)]
    return {
        "engine": "intrinsicmodal",
        "fem": {
            "folder": folder,
            "connectivity": {"line": None},
            "num_modes": case["modes"],
            "eig_type": "scipy",
            "eig_names": None,
        },
        "driver": {"typeof": "intrinsic", "sol_path": None, "save_fem": False},
        "log": {"to_file": False, "level": "warning"},
        "simulation": {"typeof": "single"},
        "systems": {
            "sett": {
                "sys1": {
                    "solution": "dynamic",
                    "bc1": "clamped",
                    "save": False,
                    "t1": case["duration"],
                    "tn": case["steps"] + 1,
                    "solver_library": "runge_kutta",
                    "solver_function": "ode",
                    "solver_settings": {"solver_name": "rk4"},
                    "xloads": {
                        "follower_forces": True,
                        "follower_points": points,
                        "x": [0.0, 2 * case["duration"]],
                        "follower_interpolation": [[f, f] for f in case["force"]],
                    },
                }
            }
        },
    }


def version_of(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:  # on the path, but not installed
        return None


def write_line(output: Any, what: dict[str, Any]) -> None:
    print(json.dumps(what), file=output, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

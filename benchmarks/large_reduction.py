"""Error-controlled reduction of a large body: a cylinder of some 300 000 DOF, ten-node tetrahedra.

Run with one thread: OMP_NUM_THREADS=1 python benchmarks/large_reduction.py
Targets: the whole reduction to 0.1 % in five minutes and 8 GB.
"""

from __future__ import annotations

from functools import partial

from measure import Steps, keep

from supple.body import RigidInterface, flexible_body
from supple.fem import Isotropic, solid_model
from supple.mesh import CellType, cylinder
from supple.reduction import ErrorControlled, SearchStep, error_controlled_modes

MATERIAL = Isotropic(youngs_modulus=100e9, poissons_ratio=0.285, density=7850.0)
TOLERANCE, N_MODES = 1e-3, 30


def main() -> None:
    steps = Steps(repeats=1, announce=partial(print, flush=True))
    mesh = cylinder(0.015, 0.3, 8, 3, 72, CellType.TETRA10)
    end = RigidInterface("end", "tip")
    # The elements are no longer needed; they would occupy a gigabyte.
    body = steps.measure(
        "K, M and body, with its checks",
        lambda: flexible_body("cylinder", solid_model(mesh, MATERIAL), [end]).linearized(),
    )
    control = ErrorControlled(TOLERANCE, N_MODES, progress=_print_step)
    modes = steps.measure(
        "error-controlled reduction", lambda: error_controlled_modes(body, control), target=300.0
    )
    print(modes.certificate)
    keep(
        "large_reduction",
        steps.rows,
        freedoms=body.n,
        cells=len(mesh.cells[CellType.TETRA10]),
        certificate=str(modes.certificate),
        seconds=dict(modes.certificate.seconds),
    )


def _print_step(step: SearchStep) -> None:
    print(f"  {step.n_modes} modes: {step.largest:.2e} in {step.seconds:.1f} s", flush=True)


if __name__ == "__main__":
    main()

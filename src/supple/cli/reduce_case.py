"""Reduce the bodies of a case file and store them, for use without their meshes."""

from __future__ import annotations

from pathlib import Path

from supple.blas_threads import one_blas_thread
from supple.cases import read_case
from supple.cases.run_files import check_not_an_input
from supple.errors import CaseError
from supple.results import body_numbers, unit_names
from supple.results.descriptions import describe_reduction
from supple.results.run_tables import body_table
from supple.simulation import reduced_bodies, store_body
from supple.simulation.stored_bodies import stored_path
from supple.terminal import print_rows, print_table, say, shown_step


def reduce_case(path: Path, folder: Path) -> None:
    """Perform the reductions of fixed size in the case at `path`; write each body to NAME-reduced.h5.

    Raises
    ------
    CaseError           mistakes in the case file; no body to reduce
    ResultFileError     a file that cannot be written
    SuppleError         errors of building and reducing
    """
    # As in a run: signs and last digits of modes depend on the number of threads.
    with shown_step("reducing") as notify, one_blas_thread():
        case = read_case(path, notify)
        check_not_an_input(case, [stored_path(folder, name) for name in case.made_here])
        bodies = reduced_bodies(case.system, case.made_here)
    if not bodies:
        raise CaseError(
            f"{path} has no body to reduce: give an elastic body a reduction of fixed size, for example "
            'reduction = { basis = "error-controlled", tolerance = 1e-3, modes = 10 }; supple run writes '
            "self-correcting bodies"
        )
    numbers = {body.name: body_numbers(body, case.units, case.fulls.get(body.name)) for body in bodies}
    print_table(*body_table({"units": unit_names(case.units), "bodies": numbers}))
    for body in bodies:
        print_rows(f"Reduction of {body.name}", describe_reduction(body.report))
        written = store_body(body, folder)
        say(f"written to {written} ({written.stat().st_size / 2**20:.1f} MiB)")

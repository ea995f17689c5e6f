"""Shared by all tests: compiled programs are kept between tests, workers and runs; meshes as bulk data."""

import gc
import os

import numpy as np
import pytest

from supple.algebra.jax_settings import bound_programs, keep_compiled_programs
from supple.mesh import CellType
from supple.terminal import WIDTH_OF_FILES, console, error_console

pytest_plugins = (
    "fixtures.strips_and_rods",
    "fixtures.reduced_blocks",
    "fixtures.made_up_solutions",
    "fixtures.strip_case",
    "fixtures.swept_pendulum",
    "fixtures.programs_in_a_folder",
    "fixtures.hdf5_copied_here",
)

# The systems here are small and run for moments: compile them quickly rather than well.
if "xla_backend_optimization_level" not in os.environ["XLA_FLAGS"]:
    os.environ["XLA_FLAGS"] += " --xla_backend_optimization_level=0 --xla_cpu_use_fusion_emitters=false"
# As wide as a file wherever the tests run: narrow tables cut words.
os.environ.pop("COLUMNS", None)
console.width = error_console.width = WIDTH_OF_FILES
# In the user's cache: another clone finds them, and so do the processes and commands that tests start.
os.environ["JAX_COMPILATION_CACHE_DIR"] = str(keep_compiled_programs())


@pytest.fixture(autouse=True)
def _programs_are_given_back():
    """A worker runs thousands of tests: more programs than a process can hold."""
    yield
    bound_programs()


# What is there now stays; what tracing makes is looked through a tenth as often, a seventh of a test's time.
gc.freeze()
gc.set_threshold(100_000, 20, 20)


class BulkData:
    """Writes Nastran bulk data: free fields, grid ids from 1, property 1, material 5 (steel)."""

    names = {kind: "CHEXA" for kind in (CellType.HEXA8, CellType.HEXA20)} | {
        CellType.TRIANGLE3: "CTRIA3",
        CellType.TETRA4: "CTETRA",
        CellType.TETRA10: "CTETRA",
    }

    def card(self, name, *words):
        """A card with as many continuations as it needs; None is a blank field."""
        data = ["" if word is None else str(word) for word in words]
        rows = [data[i : i + 8] for i in range(0, len(data), 8)]
        return "\n".join(",".join([name if i == 0 else "+", *row]) for i, row in enumerate(rows))

    def grids(self, nodes):
        return [self.card("GRID", i, None, *map(repr, map(float, x))) for i, x in enumerate(nodes, 1)]

    def elements(self, mesh):
        cards = []
        for kind, cells in mesh.cells.items():
            order = np.arange(kind.n_nodes)
            if kind is CellType.HEXA20:  # Nastran lists bottom, upright and top edges
                order = np.r_[:12, 16:20, 12:16]
            for cell in cells[:, order] + 1:
                cards.append(self.card(self.names[kind], len(cards) + 1, 1, *cell))
        return cards

    def steel(self):
        return self.card("MAT1", 5, 2.1e11, None, 0.3, 7850.0)

    def solid(self):
        return [self.card("PSOLID", 1, 5), self.steel()]

    def shell(self, thickness):
        return [self.card("PSHELL", 1, 5, thickness, 5), self.steel()]

    def deck(self, *cards):
        return "\n".join(["SOL 103", "CEND", "BEGIN BULK", *cards, "ENDDATA", ""])

    def text(self, mesh, *cards):
        return self.deck(*self.grids(mesh.nodes), *self.elements(mesh), *cards)


@pytest.fixture(scope="session")
def bulk():
    """The writer of Nastran bulk data."""
    return BulkData()

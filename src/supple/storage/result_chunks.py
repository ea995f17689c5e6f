"""Chunks of a result file: written, sealed, then committed, so that an incomplete chunk is never read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from supple.integrate.solution import Solution
from supple.storage.atomic_write import replacing
from supple.storage.dataset_labels import dataset_labels
from supple.storage.hdf5_record import dataset
from supple.storage.result_content import FORMAT, N_COLUMNS, TEXTS, VERSION, Layout, ResultHeader
from supple.storage.result_seals import NO_END, SIZE, content_seal, end_seal, header_seal, row_seal
from supple.storage.solution_arrays import Array, motion_kinds, statistics_row, to_arrays

# HDF5 stores and caches a dataset in blocks of this many bytes, or one row where a row is longer.
_BLOCK_BYTES = 16384

# Room for the indices of blocks, which grow by pages.
_INDEX_BYTES = 2**20


@dataclass
class Ledger:
    """The seals of the parts of a file as they are written.

    header : bytes          seal of the header
    layout : Layout         layout of the chunks
    rows : list of bytes    seals of the chunks
    n_times : int           number of output times written
    datasets : h5py.Dataset     by name, cached, because a look-up takes as long as a write
    """

    header: bytes
    layout: Layout
    rows: list[bytes]
    n_times: int = 0
    datasets: dict[str, h5py.Dataset] = field(default_factory=dict)

    def dataset(self, file: h5py.File, name: str) -> h5py.Dataset:
        """The dataset with that name in the file that chunks are appended to."""
        if name not in self.datasets:
            self.datasets[name] = dataset(file, name)
        return self.datasets[name]


def layout_of_chunk(arrays: Mapping[str, Array], chunk: Solution) -> Layout:
    """The layout of the rows of a chunk: shapes and kinds of motion."""
    return Layout(
        arrays={path: array.shape[1:] for path, array in arrays.items()},
        kinds=motion_kinds(chunk),
        engine_state={key: np.shape(value) for key, value in chunk.engine_state.items()},
    )


def write_whole(path: Path, header: ResultHeader, solution: Solution | None) -> Ledger:
    """Write a file with one chunk, or none, atomically."""
    arrays = {} if solution is None else to_arrays(solution)
    layout = Layout({}, {}, {}) if solution is None else layout_of_chunk(arrays, solution)
    # Values as JSON returns them, because the seal covers what is read.
    words = (header.case, *map(json.dumps, (dict(header.metadata), dict(header.inputs), asdict(layout))))
    texts: dict[str, str] = dict(zip(TEXTS, words, strict=True))
    ledger = Ledger(header_seal(texts), layout, [])
    # Built in memory, because HDF5 does not survive a failed write: see disk_space.
    with h5py.File("image", "w", driver="core", backing_store=False, libver="latest") as file:
        file.attrs["format"] = np.bytes_(FORMAT)
        file.attrs["version"] = VERSION
        for name, text in texts.items():
            # Fixed length: HDF5 stores variable lengths on a heap without checksums.
            content = text.encode()
            file.create_dataset(name, data=np.array(content, dtype=f"S{max(1, len(content))}"))
        file.create_dataset("complete", data=np.int64(0))
        _create_growing(file, "commits", np.empty((0, N_COLUMNS)))
        _create_growing(file, "seals/chunks", np.empty((0, 2 * SIZE), np.uint8))
        file.create_dataset("seals/header", data=np.frombuffer(ledger.header, np.uint8))
        file.create_dataset("seals/end", data=np.frombuffer(NO_END, np.uint8))
        if solution is not None:
            for name, array in arrays.items():
                _create_growing(file, name, array)
                for key, value in dataset_labels(name, header.metadata).items():
                    file[name].attrs[key] = value
            for key, value in solution.engine_state.items():
                _create_growing(file, f"engine_state/{key}", np.asarray(value, dtype=float)[None])
            _commit(file, ledger, arrays, solution)
        if header.complete:
            mark_complete(file, ledger)
        file.flush()
        image = file.id.get_file_image()
    ledger.datasets.clear()  # they belong to the image in memory
    with replacing(path) as temporary:
        temporary.write_bytes(image)
    return ledger


def _create_growing(file: h5py.File, name: str, array: np.ndarray) -> None:
    width = array.shape[1:]
    row_bytes = array.itemsize * max(1, int(np.prod(width)))
    # A block must not have a side of length zero, as for a rigid body's zero coordinates.
    blocks = (max(1, _BLOCK_BYTES // row_bytes), *(max(1, n) for n in width))
    file.create_dataset(name, data=array, maxshape=(None,) * array.ndim, chunks=blocks)


def most_growth(arrays: Mapping[str, Array]) -> int:
    """Upper limit of the file's growth in bytes: the rows, a partial block at either end, and their index."""
    rows = sum(array.nbytes + 2 * max(_BLOCK_BYTES, array[:1].nbytes) for array in arrays.values())
    return rows + rows // 8 + _INDEX_BYTES


def append_chunk(file: h5py.File, ledger: Ledger, arrays: Mapping[str, Array], chunk: Solution) -> None:
    """Write a chunk after the existing ones."""
    for name, array in arrays.items():
        target = ledger.dataset(file, name)
        target.resize(ledger.n_times + len(array), axis=0)
        if array.size:
            target[ledger.n_times :] = array
    for key in ledger.layout.engine_state:
        _set_row(ledger.dataset(file, f"engine_state/{key}"), len(ledger.rows), chunk.engine_state[key])
    file.flush()
    _commit(file, ledger, arrays, chunk)


def _commit(file: h5py.File, ledger: Ledger, arrays: Mapping[str, Array], chunk: Solution) -> None:
    number, n_times = len(ledger.rows), len(arrays["times"])
    state = {key: np.asarray(chunk.engine_state[key], dtype=np.float64) for key in ledger.layout.engine_state}
    row = np.concatenate([[ledger.n_times, n_times], statistics_row(chunk.statistics)])
    content = content_seal({path: (array.shape, [array]) for path, array in arrays.items()}, state)
    sealed = row_seal(ledger.header, number, row, content)
    # A chunk is valid once its row is written; therefore the seals are written first.
    _set_row(ledger.dataset(file, "seals/chunks"), number, np.frombuffer(content + sealed, np.uint8))
    file.flush()
    _set_row(ledger.dataset(file, "commits"), number, row)
    file.flush()
    ledger.rows.append(sealed)
    ledger.n_times += n_times


def _set_row(rows: h5py.Dataset, number: int, value: Any) -> None:
    rows.resize(number + 1, axis=0)
    if rows.size:
        rows[number] = value


def mark_complete(file: h5py.File, ledger: Ledger) -> None:
    """Seal the complete run."""
    dataset(file, "seals/end")[...] = np.frombuffer(end_seal(ledger.header, ledger.rows), np.uint8)
    file.flush()
    dataset(file, "complete")[()] = 1


def open_single_writer(path: Path) -> h5py.File:
    """The file in single-writer mode, in which it can be read at any time."""
    # The high-level constructor opens for writing first and then switches; a process killed in between leaves
    # a file that only a repair tool opens. The low-level call enters the mode in one step.
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_LATEST, h5py.h5f.LIBVER_LATEST)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
    flags = h5py.h5f.ACC_RDWR | h5py.h5f.ACC_SWMR_WRITE
    return h5py.File(h5py.h5f.open(str(path).encode(), flags, access))

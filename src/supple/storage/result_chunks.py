"""Chunks of a result file: written, sealed, then committed, so that an incomplete chunk is never read."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path

import h5py
import numpy as np

from supple.arrays import FloatArray
from supple.integrate.solution import Solution
from supple.storage.atomic_write import replacing
from supple.storage.dataset_labels import dataset_labels
from supple.storage.hdf5_record import dataset
from supple.storage.result_content import FORMAT, N_COLUMNS, TEXTS, VERSION, Layout, ResultHeader
from supple.storage.result_seals import NO_END, SIZE, content_seal, end_seal, header_seal, row_seal
from supple.storage.solution_arrays import motion_kinds, statistics_row, to_arrays

# HDF5 stores and caches a dataset in blocks of this many bytes, or one row where a row is longer.
_BLOCK_BYTES = 16384

# Room for the indices of blocks, which grow by pages.
_INDEX_BYTES = 2**20


class ChunkWriter:
    """Writes chunks with their seals to an open file.

    header : bytes      seal of the header
    """

    def __init__(self, file: h5py.File, header: bytes, layout: Layout) -> None:
        self.layout = layout
        self._header = header
        self._row_seals: list[bytes] = []
        self._n_times = 0
        self.go_on_in(file)

    def go_on_in(self, file: h5py.File) -> None:
        """Write further chunks to the file that was written, opened again."""
        self.file = file
        # Kept by name, because a look-up takes as long as a write.
        self._dataset = cache(partial(dataset, file))

    def append(self, arrays: Mapping[str, FloatArray], chunk: Solution) -> None:
        """Write a chunk after the existing ones."""
        for name, array in arrays.items():
            target = self._dataset(name)
            target.resize(self._n_times + len(array), axis=0)
            if array.size:
                target[self._n_times :] = array
        for key in self.layout.engine_state:
            self._set_row(f"engine_state/{key}", np.asarray(chunk.engine_state[key]))
        self.file.flush()
        self.commit(arrays, chunk)

    def commit(self, arrays: Mapping[str, FloatArray], chunk: Solution) -> None:
        """Make a chunk valid whose arrays and state are written."""
        state = {key: np.asarray(chunk.engine_state[key], np.float64) for key in self.layout.engine_state}
        row = np.array([self._n_times, len(arrays["times"]), *statistics_row(chunk.statistics)])
        content = content_seal({path: (array.shape, [array]) for path, array in arrays.items()}, state)
        sealed = row_seal(self._header, len(self._row_seals), row, content)
        # A chunk is valid once its row is written; therefore the seals are written first.
        self._set_row("seals/chunks", np.frombuffer(content + sealed, np.uint8))
        self.file.flush()
        self._set_row("commits", row)
        self.file.flush()
        self._row_seals.append(sealed)
        self._n_times += len(arrays["times"])

    def finish(self) -> None:
        """Seal the complete run."""
        self._dataset("seals/end")[...] = np.frombuffer(end_seal(self._header, self._row_seals), np.uint8)
        self.file.flush()
        self._dataset("complete")[()] = 1
        self.file.flush()

    def _set_row(self, name: str, value: np.ndarray) -> None:
        """Write the row of the next chunk."""
        rows, number = self._dataset(name), len(self._row_seals)
        rows.resize(number + 1, axis=0)
        if rows.size:
            rows[number] = value


def layout_of_chunk(arrays: Mapping[str, FloatArray], chunk: Solution) -> Layout:
    """The layout of the rows of a chunk: shapes and kinds of motion."""
    return Layout(
        arrays={path: array.shape[1:] for path, array in arrays.items()},
        kinds=motion_kinds(chunk),
        engine_state={key: np.shape(value) for key, value in chunk.engine_state.items()},
    )


def write_whole(path: Path, header: ResultHeader, solution: Solution | None) -> ChunkWriter:
    """Write a file with one chunk, or none, atomically; returns its writer, whose file is closed."""
    arrays = {} if solution is None else to_arrays(solution)
    layout = Layout({}, {}, {}) if solution is None else layout_of_chunk(arrays, solution)
    # Values as JSON returns them, because the seal covers what is read.
    words = (header.case, *map(json.dumps, (dict(header.metadata), dict(header.inputs), asdict(layout))))
    texts: dict[str, str] = dict(zip(TEXTS, words, strict=True))
    sealed = header_seal(texts)
    # Built in memory, because HDF5 does not survive a failed write: see reserve_space.
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
        file.create_dataset("seals/header", data=np.frombuffer(sealed, np.uint8))
        file.create_dataset("seals/end", data=np.frombuffer(NO_END, np.uint8))
        writer = ChunkWriter(file, sealed, layout)
        if solution is not None:
            for name, array in arrays.items():
                _create_growing(file, name, array)
                for key, value in dataset_labels(name, header.metadata).items():
                    file[name].attrs[key] = value
            for key, value in solution.engine_state.items():
                _create_growing(file, f"engine_state/{key}", np.asarray(value, dtype=float)[None])
            writer.commit(arrays, solution)
        if header.complete:
            writer.finish()
        file.flush()
        image = file.id.get_file_image()
    with replacing(path) as temporary:
        temporary.write_bytes(image)
    return writer


def _create_growing(file: h5py.File, name: str, array: np.ndarray) -> None:
    width = array.shape[1:]
    row_bytes = array.itemsize * max(1, int(np.prod(width)))
    # A block must not have a side of length zero, as for a rigid body's zero coordinates.
    blocks = (max(1, _BLOCK_BYTES // row_bytes), *(max(1, n) for n in width))
    file.create_dataset(name, data=array, maxshape=(None,) * array.ndim, chunks=blocks)


def most_growth(arrays: Mapping[str, FloatArray], engine_state: Mapping[str, FloatArray]) -> int:
    """Upper limit of the file's growth in bytes: the rows, a partial block at either end, and their index.

    engine_state : adds at most one block per key
    """
    rows = sum(array.nbytes + 2 * max(_BLOCK_BYTES, array[:1].nbytes) for array in arrays.values())
    rows += sum(max(_BLOCK_BYTES, 8 * np.size(value)) for value in engine_state.values())
    return rows + rows // 8 + _INDEX_BYTES


def open_single_writer(path: Path) -> h5py.File:
    """The file in single-writer mode, in which it can be read at any time."""
    # The high-level constructor opens for writing first and then switches; a process killed in between leaves
    # a file that only a repair tool opens. The low-level call enters the mode in one step.
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_LATEST, h5py.h5f.LIBVER_LATEST)
    access.set_fclose_degree(h5py.h5f.CLOSE_STRONG)
    flags = h5py.h5f.ACC_RDWR | h5py.h5f.ACC_SWMR_WRITE
    return h5py.File(h5py.h5f.open(str(path).encode(), flags, access))

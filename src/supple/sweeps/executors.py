"""Executors of the tasks of a sweep, as `concurrent.futures.Executor`."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from threading import Thread
from typing import Protocol

from supple.algebra.available_memory import available_memory
from supple.errors import SuppleError
from supple.optional_packages import optional_package
from supple.other_processes import available_cores

__all__ = ["Cluster", "Executors", "Given", "LocalProcesses", "MpiProcesses"]

MEMORY = 2**30
"""Memory assumed for a process and its cases, bytes."""


class Executors(Protocol):
    """Source of executors; a new one is opened after the last one has broken."""

    def opened(self) -> AbstractContextManager[Executor]:
        """Context manager of an executor, which is closed at the end of the block."""
        ...


@dataclass(frozen=True)
class LocalProcesses:
    """Processes of this computer.

    number : number of processes; by default one per core, as far as memory allows
    """

    number: int | None = None

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """Context manager of a pool of spawned processes, because JAX does not work in forked processes."""
        number = self.number or _by_memory(available_cores())
        others = multiprocessing.active_children()
        pool = ProcessPoolExecutor(number, multiprocessing.get_context("spawn"), _end_with_parent)
        try:
            yield pool
        except Exception:
            raise  # running tasks are finished
        except BaseException:
            for process in set(multiprocessing.active_children()).difference(others):
                process.terminate()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster; the folder of the sweep must have the same path on all of them.

    address : address of the scheduler, such as tcp://10.0.0.1:8786
    """

    address: str

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """Context manager of the cluster; MissingPackageError without Dask, SuppleError without scheduler."""
        distributed = optional_package("distributed", "a sweep on a Dask cluster", "cluster")
        try:
            client = distributed.Client(self.address)
        except OSError as error:
            raise SuppleError(
                f"no Dask scheduler responds at {self.address} ({error}): check the address, or start one"
            ) from error
        with client:
            yield client.get_executor(pure=False)


@dataclass(frozen=True)
class MpiProcesses:
    """MPI processes, of a command that runs under `mpiexec -n N python -m mpi4py.futures -m supple`."""

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """Context manager of the MPI processes; MissingPackageError without mpi4py."""
        futures = optional_package("mpi4py.futures", "a sweep by MPI", "mpi")
        with futures.MPIPoolExecutor() as pool:
            yield pool


@dataclass(frozen=True)
class Given:
    """An executor that the caller opens and closes."""

    executor: Executor

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """Context manager of the given executor."""
        yield self.executor


def _end_with_parent() -> None:
    """Make this process end when its parent ends, because no one would collect its results."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def wait() -> None:
        parent.join()
        os._exit(1)

    Thread(target=wait, daemon=True).start()


def _by_memory(cores: int) -> int:
    memory = available_memory()
    return cores if memory is None else max(1, min(cores, memory // MEMORY))

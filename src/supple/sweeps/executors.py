"""Where the tasks of a sweep run: any `concurrent.futures.Executor`, made by one of these."""

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
"""Bytes that a process is counted with, its cases included."""


class Executors(Protocol):
    """Makes an executor, and once more where it has broken."""

    def opened(self) -> AbstractContextManager[Executor]:
        """An executor, ready; closed with the block."""
        ...


@dataclass(frozen=True)
class LocalProcesses:
    """Processes of this machine; as many as it has cores, and memory for.

    number : of them
    """

    number: int | None = None

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """A pool of processes that are started afresh: JAX does not survive a fork."""
        number = self.number or _by_memory(available_cores())
        others = multiprocessing.active_children()
        pool = ProcessPoolExecutor(number, multiprocessing.get_context("spawn"), _end_with_parent)
        try:
            yield pool
        except Exception:
            raise  # what has begun comes to its end
        except BaseException:
            for process in set(multiprocessing.active_children()).difference(others):
                process.terminate()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


@dataclass(frozen=True)
class Cluster:
    """Workers of a Dask cluster, which see the folder of the sweep under the same path.

    address : of its scheduler, such as tcp://10.0.0.1:8786
    """

    address: str

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """The cluster as an executor; MissingPackageError without Dask, SuppleError without a scheduler."""
        distributed = optional_package("distributed", "a sweep on a Dask cluster", "cluster")
        try:
            client = distributed.Client(self.address)
        except OSError as error:
            raise SuppleError(
                f"no scheduler of Dask answers at {self.address} ({error}): check the address, or start one"
            ) from error
        with client:
            yield client.get_executor(pure=False)


@dataclass(frozen=True)
class MpiProcesses:
    """Processes of MPI: the command runs under `mpiexec -n N python -m mpi4py.futures -m supple`."""

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """The processes as an executor; MissingPackageError without mpi4py."""
        futures = optional_package("mpi4py.futures", "a sweep by MPI", "mpi")
        with futures.MPIPoolExecutor() as pool:
            yield pool


@dataclass(frozen=True)
class Given:
    """An executor that the caller opens and closes."""

    executor: Executor

    @contextmanager
    def opened(self) -> Iterator[Executor]:
        """That one."""
        yield self.executor


def _end_with_parent() -> None:
    """End this process with the one that started it, however that ends: nobody would take its results."""
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

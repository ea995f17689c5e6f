"""What a simulation leaves behind: recovery, energies, error measures, storage."""

from supple.results.json_report import write_json
from supple.results.result_reader import ResultHeader, read_header, read_last_instant, read_solution
from supple.results.storage import ResultFile, write_solution

__all__ = [
    "ResultFile",
    "ResultHeader",
    "read_header",
    "read_last_instant",
    "read_solution",
    "write_json",
    "write_solution",
]

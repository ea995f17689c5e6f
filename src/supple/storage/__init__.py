"""Files of results and reduced bodies that survive a kill."""

from supple.storage.file_name import file_name
from supple.storage.json_report import (
    write_json,
)
from supple.storage.reduced_body_hdf5 import (
    holds_reduced_body,
    read_interface_names,
    read_reduced_body,
    write_reduced_body,
)
from supple.storage.result_content import (
    DamagedResultError,
    ResultHeader,
)
from supple.storage.result_file import (
    ResultFile,
    write_errors,
    write_solution,
)
from supple.storage.result_reader import (
    read_header,
    read_last_instant,
    read_solution,
    read_sound_part,
)

__all__ = [
    "DamagedResultError",
    "ResultFile",
    "ResultHeader",
    "file_name",
    "holds_reduced_body",
    "read_header",
    "read_interface_names",
    "read_last_instant",
    "read_reduced_body",
    "read_solution",
    "read_sound_part",
    "write_errors",
    "write_json",
    "write_reduced_body",
    "write_solution",
]

"""Files of Radioss."""

from supple.importers.radioss.flexible_body_file import (
    FlexibleBodyFile,
    read_flexible_body_file,
    write_flexible_body_file,
)

__all__ = ["FlexibleBodyFile", "read_flexible_body_file", "write_flexible_body_file"]

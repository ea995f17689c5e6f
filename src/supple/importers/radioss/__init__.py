"""Files of Radioss."""

from supple.importers.radioss.flexible_body_file import *

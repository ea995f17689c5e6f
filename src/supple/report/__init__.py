"""Report of a run as one HTML page that needs no network."""

from supple.report.player import *
from supple.report.sweep_page import *
from supple.report.write_report import *
from supple.report.write_rest_report import *

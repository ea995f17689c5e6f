"""Numbers of a finished run and its tables: summary, error measures, round-off."""

from supple.results.body_surface import *
from supple.results.error_measures import *
from supple.results.round_off import *
from supple.results.run_summary import *

"""Results of a finished run: summary, tables, error measures, surfaces to draw."""

from supple.results.body_surface import *
from supple.results.error_measures import *
from supple.results.round_off import *
from supple.results.run_summary import *

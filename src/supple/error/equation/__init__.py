"""The error equation: error of a reduced run caused by its bases, from the run's own residual."""

from supple.error.equation.assessed_body import *
from supple.error.equation.error_history import *
from supple.error.equation.error_space import *
from supple.error.equation.nonlinearity import *
from supple.error.equation.run_columns import *

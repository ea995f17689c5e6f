"""The error equation: what the basis of a reduced run costs, from the run's own residual."""

from supple.error.equation.assessed_body import *
from supple.error.equation.error_history import *
from supple.error.equation.error_space import *
from supple.error.equation.nonlinearity import *
from supple.error.equation.run_columns import *

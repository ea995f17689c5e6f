"""The error equation: what the basis of a reduced run costs, told by the run's own residual."""

from supple.error_equation.error_history import *
from supple.error_equation.error_space import *
from supple.error_equation.judged_body import *
from supple.error_equation.nonlinearity import *
from supple.error_equation.run_columns import *

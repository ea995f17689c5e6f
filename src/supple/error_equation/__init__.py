"""The error equation: what the basis of a reduced run costs, told by the run's own residual."""

from supple.error_equation.error_history import (
    ErrorEquation,
    ErrorHistory,
    TangentMotion,
)
from supple.error_equation.error_space import (
    ErrorSpace,
    ModesInFrame,
    error_space,
    modes_in_frame,
)
from supple.error_equation.judged_body import (
    JudgedBody,
    MissedAtRest,
    StartError,
)
from supple.error_equation.nonlinearity import (
    second_correction,
)
from supple.error_equation.run_columns import (
    RunColumns,
    run_columns,
)

__all__ = [
    "ErrorEquation",
    "ErrorHistory",
    "ErrorSpace",
    "JudgedBody",
    "MissedAtRest",
    "ModesInFrame",
    "RunColumns",
    "StartError",
    "TangentMotion",
    "error_space",
    "modes_in_frame",
    "run_columns",
    "second_correction",
]

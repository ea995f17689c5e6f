"""Compiled, dense engine for machines of rigid and reduced bodies.

`time_step` defines a step and the integration between output times, `newton` and `modified_newton` the
iteration of a step, `step_equations` its linear equations, `engine` the calls of the compiled program.
"""

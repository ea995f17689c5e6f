"""Full-order engine for bodies with all finite-element freedoms: sparse Newton steps.

`full_system` contains the equations and their linear solution, `implicit_step` and `newton` the iteration of
one step, `engine` the steps between output times.
"""

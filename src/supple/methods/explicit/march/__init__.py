"""Compiled explicit time integration: its model, its state, and its steps.

The `build*` modules convert a system to arrays. `march_model` defines the model and the state, `march_step`
one step of the frames with several steps of the explicit nodes, `interval` the integration between output
times.
"""

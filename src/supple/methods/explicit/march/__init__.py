"""Compiled explicit time integration: its model, its state, and its steps."""

"""Export of a machine as plain C, generated from the JAX trace of its time steps."""

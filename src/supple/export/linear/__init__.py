"""A machine linearised about its equilibrium, for export: matrices with named inputs and outputs."""

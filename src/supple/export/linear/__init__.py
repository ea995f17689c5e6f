"""A machine linearized about its equilibrium, for export: matrices with named inputs and outputs."""

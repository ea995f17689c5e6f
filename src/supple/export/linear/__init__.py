"""A machine as a linear one about its equilibrium, for export: matrices beside named inputs and outputs."""

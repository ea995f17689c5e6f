"""A machine as a functional mock-up unit (FMU) for co-simulation, around its C."""

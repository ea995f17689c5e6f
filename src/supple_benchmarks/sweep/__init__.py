"""The benchmark of sweeps: throughput a core, digits against single runs, memory, time to read a column."""

"""Benchmark of sweeps: throughput per core, agreement with single runs, memory, time to read a column."""

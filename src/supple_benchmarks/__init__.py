"""Published benchmarks, repeated: each prints computed and published numbers.

A folder contains one published case: its problem, runs, report, figures and command. `supple benchmark` finds
the command by the entry points of the group `supple.benchmarks`. The modules at the top level are shared.
"""

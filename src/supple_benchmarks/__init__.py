"""Published benchmarks, repeated: each prints computed and published numbers.

A folder holds a published case: its problem, its runs, its report, its figures and its command, which
`supple benchmark` finds by the entry points of the group `supple.benchmarks`. On top stands what cases share.
"""

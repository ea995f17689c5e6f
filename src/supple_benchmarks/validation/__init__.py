"""`supple benchmark validation`: ordinary questions of all four methods beside references that share nothing with them.

A file holds the cases of one topic and ends in `CASES`; `every_case.py` lists the topics.
"""

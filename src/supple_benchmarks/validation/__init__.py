"""`supple benchmark validation`: ordinary questions of all four methods beside independent references.

A file holds the cases of one topic and ends in `CASES`; `every_case.py` lists the topics.
"""

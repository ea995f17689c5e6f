"""`supple benchmark validation`: basic cases of all four methods against independent references.

A file holds the cases of one topic and ends in `CASES`; `every_case.py` lists the topics.
"""

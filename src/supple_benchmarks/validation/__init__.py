"""`supple benchmark validation`: basic cases of all four methods, compared with independent references.

Each file of a topic contains its cases and ends in `CASES`; `every_case.py` lists the topics.
"""

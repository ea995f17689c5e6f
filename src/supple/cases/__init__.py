"""The case file: one file per section, its tables and their build."""

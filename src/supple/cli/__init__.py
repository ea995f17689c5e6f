"""The command line: parsing, calls, printing."""

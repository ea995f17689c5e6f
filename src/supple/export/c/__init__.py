"""A machine as plain C: its compiled march, printed from the traced program."""

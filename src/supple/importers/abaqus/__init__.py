"""Abaqus and CalculiX input files (.inp): what they describe as a Deck, and their mesh alone."""

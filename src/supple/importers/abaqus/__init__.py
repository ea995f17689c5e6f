"""Abaqus and CalculiX input files (.inp), read as a Deck or as a Mesh."""

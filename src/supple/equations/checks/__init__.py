"""Checks of a motion: energies, constraint residuals, validity, the spectrum of the loads."""

"""What a motion says about itself: energies, constraint residuals, validity, the spectrum of the loads."""

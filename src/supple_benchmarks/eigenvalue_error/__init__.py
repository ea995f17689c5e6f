"""The eigenvalue errors of [Han2020], controlled."""

"""The intrinsic modal reduction, compared with its paper, closed forms and the other methods."""

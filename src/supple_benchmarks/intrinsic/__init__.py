"""The intrinsic modal reduction beside its paper, closed forms and the other methods."""

"""Estimated against true errors: self-correcting runs, compared with full runs that they do not use."""

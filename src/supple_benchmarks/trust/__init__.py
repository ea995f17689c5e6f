"""Is the stated error the true error? Runs that correct themselves, beside full runs they have never seen."""

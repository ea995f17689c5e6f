"""Controllers: laws that depend on readings of the machine, in every step or at sampling instants."""

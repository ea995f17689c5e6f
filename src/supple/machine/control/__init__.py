"""Controllers: laws that depend on what they read of the machine, in every step or at sampling instants."""

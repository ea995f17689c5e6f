"""Tables of wind turbines."""

"""The 61.5 m blade of [Wu2019] section 6.2."""

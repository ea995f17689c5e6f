"""The rotating beam of [Wu2019] section 6.1."""

"""Forces and torques between two markers, one law per module."""

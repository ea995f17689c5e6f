"""Compiled, dense engine for machines of rigid and reduced bodies."""

"""How far the eigenvalues of a reduced body are from those of the whole one."""

"""Small matrices of a body, from vibrations with fixed or free interfaces."""

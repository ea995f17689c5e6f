"""Compiled programs kept from run to run, and the processes that compile and call them."""

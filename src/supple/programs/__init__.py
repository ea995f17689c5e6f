"""Cache of compiled programs, and processes that compile and call them."""

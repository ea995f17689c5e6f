"""Cache of compiled programs, and worker processes that execute them."""

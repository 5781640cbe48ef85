"""One dyad as equations: the documented, broadcasting faces of the core."""

"""Position problems: partitions of the closure, solvers and their solutions."""

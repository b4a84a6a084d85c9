"""Long random and hostile runs, a script each, outside the gate."""

"""Motion: velocity equations and Jacobians, and modes followed along paths."""

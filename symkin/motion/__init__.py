"""Motion: velocity equations and Jacobians, as numbers and as symbols."""

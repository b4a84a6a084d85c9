"""The loop closure F(q, x, X, p) = 0: chains of joints, the rows of each loop, pose forms, parameters, and walks over its graph."""

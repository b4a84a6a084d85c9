"""Build the loop closure F(q, x, X, p) = 0: chains of joints, rows of each loop, forms of the pose,
parameters, walks over its graph.
"""

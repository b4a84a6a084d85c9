"""Robots as others write them: MJCF, URDF and SDF, read into a graph of links."""

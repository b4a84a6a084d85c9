"""Singular configurations: which kind, how near, the motion or wrench that shows them, and their
loci over a plane.
"""

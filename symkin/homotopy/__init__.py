"""Roots over the complex numbers: algebraic systems, path tracking, generic starts, the ends of
paths.
"""

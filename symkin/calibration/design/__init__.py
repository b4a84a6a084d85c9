"""Experiments before they are made: simulated readings, and plans of configurations that identify
the geometry best.
"""

"""Velocity equations and Jacobians, as numbers and as symbols."""

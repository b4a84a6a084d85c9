"""Mechanisms, their description files and the symbolic loop closure."""

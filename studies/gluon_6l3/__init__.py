"""Gluon-6L3, a 6R arm with three parallel axes (tutorial page)."""

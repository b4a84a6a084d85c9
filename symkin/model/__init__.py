"""Describe mechanisms: joints, limbs, Denavit-Hartenberg tables, and the files that hold them."""

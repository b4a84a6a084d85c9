"""Wrist-offset telescopic Pieper robot, 5R1P (Yao 2020)."""

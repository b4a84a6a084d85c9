"""Proofs by ball arithmetic that approximate roots stand for exact ones, and theorems that bound
their number.
"""

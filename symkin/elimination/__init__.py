"""Closed forms: solve the rows of a block of unknowns by formulas, where their structure allows.

`rows` writes closure rows as polynomials (`polynomial`) in lengths and in cosines and sines of
angles, with expressions of the known values as coefficients. `workspace` holds what is left to
solve. `solving` solves a row that has one unknown, `eliminating` takes unknowns out of the others;
each step is a sentence of the derivation. `closed_form` runs them and gives the formulas.
"""

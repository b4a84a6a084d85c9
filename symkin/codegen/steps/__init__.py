"""Steps of a problem, and what they need: Newton iterations and their linear solver, formulas of
parts, guards of lines, limits, sampled configurations.
"""

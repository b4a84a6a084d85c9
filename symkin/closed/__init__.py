"""Joint values of serial arms by formulas: the structure of an arm, the plan that it allows, its
evaluation.
"""

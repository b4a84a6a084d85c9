"""Compute with poses, rotations and screws: one set of formulas for floats, NumPy arrays and CasADi
expressions.
"""

from symkin.spatial.pose import Pose

__all__ = ["Pose"]

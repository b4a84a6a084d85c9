"""Calibration: geometry from joint readings and what is known of each posture."""

"""Calibration: identify a mechanism's geometry from joint readings and measurements of its platform."""

"""The estimate: closure and readings of all configurations, their residuals, and the least squares
over parameters and poses.
"""

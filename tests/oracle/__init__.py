"""Independent accounts of mechanisms that judge symkin's: closures, graphs, searches, other
tools.
"""

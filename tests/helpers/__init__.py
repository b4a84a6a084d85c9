"""Shared by tests, campaigns and benchmarks: sample mechanisms, laws that results must satisfy,
tools that build and run generated C.
"""

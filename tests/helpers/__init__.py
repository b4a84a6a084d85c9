"""Shared by the tests and benchmarks: sample mechanisms, laws that results must satisfy, tools that build and run generated C."""

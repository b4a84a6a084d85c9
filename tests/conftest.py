"""One hypothesis profile for all tests: the same examples each time, on any machine."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "symkin", derandomize=True, deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("symkin")

"""The closure written in other languages."""

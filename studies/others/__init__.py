"""Further published mechanisms, and studies of enumeration itself."""

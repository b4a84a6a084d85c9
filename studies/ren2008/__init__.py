"""XJ-HEXAS, a 6-UPS platform (Ren 2008)."""

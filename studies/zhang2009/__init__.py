"""Six-SPS Gough-Stewart platform (Zhang 2009)."""

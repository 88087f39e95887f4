"""Estimate how far rounding alone may separate two correct sources."""

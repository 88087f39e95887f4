"""Equations of any size, written as named results."""

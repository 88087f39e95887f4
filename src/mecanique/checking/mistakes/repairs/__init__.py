"""Repair one part of a formula: a term, a letter, a number, a function."""

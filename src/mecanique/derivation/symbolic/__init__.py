"""Derive in symbols, on Poisson series: Lagrange, Newton–Euler and virtual work."""

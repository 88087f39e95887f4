"""Integrators: each method and what it needs, in a module of its own."""

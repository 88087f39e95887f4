"""Wheels in mesh: where they touch, and teeth to draw them with."""

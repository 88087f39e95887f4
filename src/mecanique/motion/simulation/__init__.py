"""Integrate a mechanism's equations of motion."""

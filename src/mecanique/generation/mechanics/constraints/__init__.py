"""Contacts, loops and guiding elements, and the constrained equations of motion."""

"""Loops and contacts in numbers, and the equations of motion that they hold."""

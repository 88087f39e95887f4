"""Straight-line programs: recorded, differentiated, evaluated, listed; they know no mechanics."""

"""Equations of motion in other programs: compiled functions and models of the FMI standard."""

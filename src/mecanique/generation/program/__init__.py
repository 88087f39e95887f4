"""The straight-line program from which code for every language and integrator is written."""

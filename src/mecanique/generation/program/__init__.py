"""The straight-line program, which every language and every integrator is written from."""

"""Closed forms compiled to fast code: the straight-line program, Python and heyoka."""

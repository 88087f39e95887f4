"""The engine of a page: what the page computes by itself, as one program."""

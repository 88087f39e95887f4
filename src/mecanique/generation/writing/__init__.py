"""Write equations of any size as lists of named results."""

"""What would mend a part of a formula: a term, a letter, a number, a function."""

"""Write the steps of the methods in words and formulas, in textbook order."""

"""Find mistakes that explain a wrong formula, the likeliest first."""

"""The languages: each writes the files of a program, and of the test that compares it."""

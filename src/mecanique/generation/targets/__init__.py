"""The languages, each of which writes a program and the test that compares it."""

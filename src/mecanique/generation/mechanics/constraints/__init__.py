"""Contacts, loops and elements that guide, and the equations of motion they hold."""

"""What holds coordinates together: loops, contacts, elements and velocity constraints."""

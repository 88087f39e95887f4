"""What ties the bodies of a mechanism besides its joints: loops, contacts, velocity constraints."""

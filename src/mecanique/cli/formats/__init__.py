"""What commands print at length: the register of the chapter, derivations, small motions."""

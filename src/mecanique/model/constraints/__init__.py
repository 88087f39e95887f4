"""What holds coordinates together: loops, contacts, elements and velocity constraints.

Here they are stated. Their laws stand in `mecanique.derivation.mechanics`: rolling in `contacts`,
cords and gears in `elements`, friction and impact in `switching`.
"""

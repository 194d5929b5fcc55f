"""Where the damage is, and how well it is repaired: section 6.2."""

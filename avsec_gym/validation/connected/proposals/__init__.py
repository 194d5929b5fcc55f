"""Where objects may be, all around a vehicle: the validation regions (thesis, section 4.4.2)."""

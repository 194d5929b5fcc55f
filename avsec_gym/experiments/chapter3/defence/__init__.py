"""What a validator before the detector is worth."""

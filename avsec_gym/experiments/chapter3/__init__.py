"""Chapter 3: validating the sensors of one vehicle."""

"""Chapter 4 of the thesis: sensor data validation for connected vehicles."""

"""What an attacker does to sensors, images or detections: one attack, one file."""

"""What recovered scans are worth in driving terms (section 6.2)."""

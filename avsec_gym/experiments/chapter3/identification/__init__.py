"""Is an attack detected, and are the attacked sensors named?  Tables 3.1 and 3.2."""

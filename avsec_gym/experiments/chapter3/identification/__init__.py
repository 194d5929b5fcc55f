"""Is an attack noticed, and are the attacked sensors named?  Tables 3.1 and 3.2."""

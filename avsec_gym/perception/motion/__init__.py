"""`C`, the moving-object classifier: b> = C(b, I_l, I_r) (thesis, section 5.3.1)."""

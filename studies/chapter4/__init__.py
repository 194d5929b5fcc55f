"""Evidence of chapter 4, beside its experiment."""

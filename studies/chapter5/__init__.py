"""Evidence of chapter 5."""

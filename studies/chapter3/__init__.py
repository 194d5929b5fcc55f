"""Evidence of chapter 3."""

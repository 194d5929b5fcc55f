"""The evidence: what only this project's pages of results need."""

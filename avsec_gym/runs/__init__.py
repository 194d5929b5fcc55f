"""Runs: experiments done cell by cell, stored in a folder, resumed, read back."""

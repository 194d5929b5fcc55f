"""The error models that the package ships: what is detected, fitted, held against other drives."""

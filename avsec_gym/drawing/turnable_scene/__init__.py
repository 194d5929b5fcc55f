"""A scene that one can turn, in a page: what is there, what the car believes, and what it does."""

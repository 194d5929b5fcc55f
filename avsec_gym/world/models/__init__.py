"""Models of things: vehicles, people, plants, buildings, street furniture."""

"""What connected vehicles and the base station send each other, with its exact number of bytes."""

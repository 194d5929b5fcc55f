"""`python -m avsec_gym` is `avsec`."""

from avsec_gym.cli import main

main()

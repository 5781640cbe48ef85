"""`python -m telespring` is the command `telespring`."""

from telespring.cli import main

main()

"""`python -m symkin` is the command `symkin`."""

from symkin.cli import main

main()

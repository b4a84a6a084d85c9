"""`python -m symkin` is the command `symkin`."""

from symkin.cli.app import main

main()

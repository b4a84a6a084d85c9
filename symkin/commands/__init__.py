"""The commands of the command line, one file for each group; `symkin.cli` registers and runs them."""

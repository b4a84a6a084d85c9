"""The commands of the command line, one file for each group; `app` registers and runs them."""

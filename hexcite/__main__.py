"""`python -m hexcite`: the command where no script of it is on the path."""

from hexcite.cli import main

main()

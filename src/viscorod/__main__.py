"""``python -m viscorod``: the command line."""

from viscorod.cli import main

main()

"""``python -m viscorod``: the command line."""

from viscorod.cli.app import main

main()

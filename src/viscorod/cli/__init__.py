"""The command line ``viscorod``, one module per family of commands."""

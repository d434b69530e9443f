"""The command `rectmerge`, one module per subcommand."""

"""Command `rectmerge`, one module per subcommand."""

"""The command `rectbench`, one module per group of subcommands."""

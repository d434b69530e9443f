"""Command `rectbench`, one module per group of subcommands."""

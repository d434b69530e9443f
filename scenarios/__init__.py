"""The evaluation suite: what is evaluated, on what, and how the answers are scored."""

"""The default method: rectangles of the free space as hypotheses, the walls of both maps as their judge."""

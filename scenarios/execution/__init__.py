"""Worker processes, limits, journals and progress."""

"""The folder and the files that a merge writes."""

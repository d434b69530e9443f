"""Results of a merge: the folder, its files, and the summary for the terminal."""

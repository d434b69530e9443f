"""Any number of maps: partners ranked, pairs asked, placements inferred jointly."""

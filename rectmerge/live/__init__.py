"""Maps that grow while robots explore: merged as soon as that can be trusted, from topics or from a recording."""

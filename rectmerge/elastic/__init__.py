"""Elastic alignment: a smooth displacement of map B, after its similarity, for maps that bend against each other."""

"""Page of an alignment: both maps, their candidates, and a placement by hand."""

"""An answer as a page to look at: both maps, their candidates, and a placement by hand."""

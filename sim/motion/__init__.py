"""How robots drive and explore."""

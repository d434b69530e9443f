"""What people use instead: each method written from its paper, behind the same protocol."""

"""Every method people use, compared: who takes part, how they are tuned, what is run, and the page of it."""

"""Several aligned maps made into one."""

"""Odometry, scan matching, loop closure and mapping."""

"""Faults tried on the follower: what each does, what must come of it, and whether it did."""

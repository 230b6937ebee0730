"""What the leader does to the hands: force programmes."""

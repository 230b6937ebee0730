"""ZMP, support polygon, and the law that keeps the ZMP inside it."""

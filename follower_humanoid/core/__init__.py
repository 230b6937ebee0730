"""The vocabulary of the chain: samples, topics, configuration. Everything may import it; it imports nothing."""

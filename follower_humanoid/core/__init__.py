"""The vocabulary of the chain: samples, topics, configuration; imports nothing of the rest."""

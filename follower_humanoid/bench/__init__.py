"""Scenarios with required numbers, and the measures taken on their runs."""

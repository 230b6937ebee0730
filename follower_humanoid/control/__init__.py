"""From joint reference to motor voltage: legs and trunk, arms."""

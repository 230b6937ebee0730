"""From sensor readings to the external wrench on each hand."""

"""From the hand wrench to the four walking parameters and on to the joint reference of a step."""

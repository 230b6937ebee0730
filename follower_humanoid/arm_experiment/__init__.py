"""Experiments with one arm on a fixed trunk: a board to write on, a target and somebody who pushes."""

"""Figures of a run, shared by the report and the viewer."""

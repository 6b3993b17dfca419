"""Frames of a run as pictures, plots and video."""

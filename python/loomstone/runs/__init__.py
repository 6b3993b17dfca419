"""Runs in directories: writing, resuming, reading, verifying."""

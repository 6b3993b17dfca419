"""Runs in directories: writing, resuming, reading and verification."""

"""Modules that the whole package shares: arguments, quantities with units, pickling."""

"""Modules that all others share: arguments, quantities with units, pickling."""

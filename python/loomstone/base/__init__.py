"""Modules shared by the whole package, such as checks of arguments, units and pickling."""

"""What all rooms share: arguments, quantities with units, pickling."""

"""Fabrics: materials with their limits and sources, fits to measured curves, laboratory tests."""

from .fabric import fabrics

"""The message for a failed claim of a scene file. Claims are assertions."""

from __future__ import annotations

import traceback

__all__ = ["broken_claim"]


def broken_claim(error: AssertionError) -> str:
    """Returns a sentence with the message of the assertion or, if it has none, its location."""
    message = " ".join(str(error).split())
    frames = traceback.extract_tb(error.__traceback__)
    if not message and frames:
        last = frames[-1]
        message = f"{last.filename}, line {last.lineno}: {last.line}"
    return f"a claim does not hold: {message}"

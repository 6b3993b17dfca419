"""Reads image files of any format that Pillow reads."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput

__all__ = ["read_image"]


def read_image(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """Returns an image (height x width x 4): 8-bit RGBA, rows from the top.

    Grey values of 16 bits are reduced to their high bytes.

    Raises InvalidInput if the file cannot be read as an image.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            # True for grey values of 16 bits. An image of mode I may have values of 8 bits only.
            deep = image.mode.startswith("I;16") or (
                image.mode == "I" and int(np.asarray(image).max(initial=0)) > 255
            )
            shown = Image.fromarray(_high_bytes(image)) if deep else image
            return np.asarray(shown.convert("RGBA"))
    except FileNotFoundError:
        raise InvalidInput(f"{path}: there is no such image; give the path of a file") from None
    except UnidentifiedImageError:
        raise InvalidInput(
            f"{path}: must be an image, such as a PNG or JPEG file, but Pillow cannot read it"
        ) from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        told = " ".join(str(error).split())
        raise InvalidInput(f"{path}: the image cannot be read: {told}") from None


def _high_bytes(image: Any) -> NDArray[np.uint8]:
    values = np.asarray(image).astype(np.int64)
    return (np.clip(values, 0, 65535) // 256).astype(np.uint8)

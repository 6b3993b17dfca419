"""Reads image files of any format that Pillow reads."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from .._core import InvalidInput

__all__ = ["read_image"]


def read_image(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """Returns an image (height x width x 4): 8-bit RGBA, rows from the top.

    Raises InvalidInput if the file cannot be read as an image.
    """
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            return np.asarray(image.convert("RGBA"))
    except FileNotFoundError:
        raise InvalidInput(f"{path}: there is no such image; give the path of a file") from None
    except UnidentifiedImageError:
        raise InvalidInput(
            f"{path}: must be an image, such as a PNG or JPEG file, but Pillow cannot read it"
        ) from None
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        told = " ".join(str(error).split())
        raise InvalidInput(f"{path}: the image cannot be read: {told}") from None

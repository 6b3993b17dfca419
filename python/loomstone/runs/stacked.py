"""An array over all frames of a run, read on demand."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .._core import Frame

__all__ = ["Stacked", "StoredFrames"]


def _chooses_frames(first: Any) -> bool:
    """Returns whether `first`, the first part of an index, only chooses frames.

    `first` must not be a slice.

    The result is True for integers, arrays of integers and masks with one axis.
    """
    if first is None or first is Ellipsis or isinstance(first, tuple):
        return False
    array = np.asarray(first)
    return array.dtype.kind in "iu" or (array.dtype == bool and array.ndim == 1)


class StoredFrames(Protocol):
    """Interface of an object that contains the frames of a run. loomstone.Run implements it."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Frame: ...


class Stacked(np.lib.mixins.NDArrayOperatorsMixin):
    """An array that each frame has, such as positions, stacked over the frames along a first axis.

    It is indexed like a numpy array, and reads only the frames that an integer, a slice, an array
    of integers or a mask at the first place of the index chooses. Operators and functions of
    numpy, such as `2 * array` and np.max(array), read all frames. np.asarray() returns an array of
    all frames, which also has the methods of numpy arrays.
    """

    def __init__(self, frames: StoredFrames, name: str) -> None:
        self._frames, self._name = frames, name

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: Any) -> Any:
        first, *others = index if isinstance(index, tuple) and index else (index,)
        if isinstance(first, slice):
            return self._stacked(range(len(self))[first])[(slice(None), *others)]
        if _chooses_frames(first):
            frames = np.arange(len(self))[first]
            places = np.arange(frames.size).reshape(frames.shape)
            return self._stacked(frames.ravel())[(places, *others)]
        return np.asarray(self)[index]  # such as an ellipsis or a mask of several axes

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        return (np.array(self._of(i)) for i in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self._stacked(range(len(self))), dtype)

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **more: Any) -> Any:
        read = [np.asarray(each) if isinstance(each, Stacked) else each for each in inputs]
        return getattr(function, method)(*read, **more)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the stacked array."""
        return (len(self), *(self._of(0).shape if len(self) else (0,)))

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """Data type of the entries, float64."""
        return np.dtype(np.float64)

    def __repr__(self) -> str:
        return f"<{self._name} of {' x '.join(map(str, self.shape))}, read as it is sliced>"

    def _of(self, frame: int) -> NDArray[np.float64]:
        array: NDArray[np.float64] = getattr(self._frames[frame], self._name)
        return array

    def _stacked(self, frames: Any) -> NDArray[np.float64]:
        arrays = [self._of(int(i)) for i in frames]
        return np.stack(arrays) if arrays else np.empty((0, *self.shape[1:]))

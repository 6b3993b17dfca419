"""Tables (CSV) in the directory of a run."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from .._core import CacheError
from ..base.replacement import replacement

__all__ = ["read_rows", "read_table", "write_table"]


def read_rows(path: Path) -> tuple[list[str], list[list[str]]]:
    """Returns the header and the rows of a CSV file; the header of an empty file is empty.

    The last row is skipped if it does not end with a line break, because then it was cut off when a
    process was killed. Raises CacheError if the file is not a table.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(file)
        cut_off = len(lines) > 1 and not lines[-1].endswith(("\r", "\n"))
        header, *rows = list(csv.reader(lines[:-1] if cut_off else lines)) or [[]]
    except (UnicodeDecodeError, csv.Error) as error:
        raise CacheError(
            f"{path}: must be a table (CSV), but cannot be read as one: {error}; run the scene"
            " again"
        ) from None
    return header, rows


def read_table(path: Path, first: str) -> tuple[list[str], list[list[str]]]:
    """Returns the header and the rows of a CSV file of numbers.

    first : name that the first column must have

    A last row without a line break is skipped, as in read_rows(). Raises CacheError for another
    header, and for any other row that does not consist of one number per column. The message names
    the line of the row.
    """
    header, rows = read_rows(path)
    if header[:1] != [first]:
        raise CacheError(
            f"{path}: must begin with the column {first!r}, got {','.join(header)[:60]!r}; run the"
            " scene again"
        )
    for number, row in enumerate(rows):
        if len(row) == len(header) and all(map(_is_number, row)):
            continue
        raise CacheError(
            f"{path}, line {number + 2}: must be {len(header)} numbers, got {','.join(row)[:60]!r};"
            " remove this line or run the scene again"
        )
    return header, rows


def write_table(path: Path, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Writes a whole CSV file. An existing file is replaced when the new one is complete.

    Raises CacheError if the file cannot be written.
    """
    with (
        replacement(path, "the table") as unfinished,
        unfinished.open("w", newline="", encoding="utf-8") as file,
    ):
        csv.writer(file).writerows([header, *rows])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True

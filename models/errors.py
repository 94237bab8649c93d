"""The exceptions of helmbench: bad input, a faulty environment, a method that does not apply, a failed fit."""

from __future__ import annotations

from unicodedata import category

HIDDEN = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""Categories of Unicode that steer a terminal or turn the direction of what follows."""
MOST_LETTERS = 500
"""Letters of a message and of a column's name beyond which they are cut in the line that is shown."""


def visible(text: str, kept: str = "") -> str:
    """A text whose control characters and marks of writing direction are shown as escapes, but those in `kept`."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        letter if letter in kept or category(letter) not in HIDDEN else ascii(letter)[1:-1] for letter in text
    )


class BadInput(ValueError):
    """Input that cannot be used; `str()` is one line that says where and what to do.

    Parameters
    ----------
    message : what is wrong.
    file : file (or record) that holds the fault.
    row : line number in that file, counted from 1 as an editor shows it.
    column : name of the column.
    hint : what to do about it.
    """

    def __init__(
        self,
        message: str,
        *,
        file: object = None,
        row: int | None = None,
        column: str | None = None,
        hint: str | None = None,
    ) -> None:
        self.message, self.file, self.row, self.column, self.hint = message, file, row, column, hint
        super().__init__(self._line())

    def _line(self) -> str:
        place = [f"row {self.row}"] if self.row is not None else []
        place += [f"column {self.column[:MOST_LETTERS]}"] if self.column is not None else []
        file = "" if self.file is None else str(self.file)
        parts = [file if len(file) <= 2 * MOST_LETTERS else f"...{file[3 - 2 * MOST_LETTERS :]}"] if file else []
        parts += [", ".join(place)] if place else []
        said = self.message if len(self.message) <= MOST_LETTERS else f"{self.message[: MOST_LETTERS - 3]}..."
        text = ": ".join([*parts, said]) + (f"; {self.hint}" if self.hint else "")
        return visible(" ".join(text.split()))

    def __reduce__(self):
        state = {"file": self.file, "row": self.row, "column": self.column, "hint": self.hint}
        return _rebuild, (type(self), self.message, state)


def _rebuild(kind: type[BadInput], message: str, state: dict) -> BadInput:
    return kind(message, **state)


class EnvironmentFault(BadInput):
    """The machine, not the input, is at fault: no folder for compiled code, a full disk, a lost cluster.

    It ends a suite and is never stored as the failure of a method.
    """


class CannotFit(Exception):
    """The method does not apply to these records or this model: the row becomes `not_applicable`."""

    def __init__(self, reason: str) -> None:
        self.reason = " ".join(reason.split())
        super().__init__(self.reason)


class FitFailed(Exception):
    """The method applies but gave no usable estimate: the row becomes `failed`."""

    def __init__(self, reason: str) -> None:
        self.reason = " ".join(reason.split())
        super().__init__(self.reason)

"""Methods around something that has options itself: a regressor, or another method."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from .base import Method
from .options import Option


class Wrapper(Method):
    """Base class of methods whose other options are those of what they wrap.

    Options of the wrapped thing are stored in `inner_options`, and only those that are stated.
    """

    wrapped: ClassVar[Mapping[str, Option]] = {}
    """Options of the wrapped thing."""
    own: ClassVar[tuple[str, ...]] = ()
    """Options that are not those of the wrapped thing."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.own = tuple(cls.options)
        cls.options = {**cls.options, **{name: one for name, one in cls.wrapped.items() if name not in cls.own}}

    def __init__(self, **options: Any) -> None:
        self.inner_options: dict[str, Any] = {}
        for name in self.own:
            setattr(self, name, self.options[name].value)
        self.set_params(**options)

    def _options(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.own} | self.inner_options

    def _set_option(self, name: str, value: Any) -> None:
        if name in self.own:
            setattr(self, name, value)
        else:
            self.inner_options[name] = value

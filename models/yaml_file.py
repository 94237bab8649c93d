"""YAML data files: read, and checked against a pydantic model; every fault is one line with file and key.

Modules that declare such models are imported only where a file is read, so that the command line starts without
pydantic.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictStr,
    ValidationError,
    WrapValidator,
)

from .errors import BadInput

Content = TypeVar("Content", bound="FileContent")


class FileContent(BaseModel):
    """Base of the models: unknown keys are refused, instances cannot be changed."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def needs(words: str) -> WrapValidator:
    """Whatever is wrong with a value is told as `needs WORDS`."""

    def check(value: Any, handler: Any) -> Any:
        try:
            return handler(value)
        except ValidationError:
            shown = str(value).lower() if isinstance(value, bool) else str(value)
            raise ValueError(f"needs {words}, not {shown}") from None

    return WrapValidator(check)


def _listed(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else [value]


def _groups(value: Any) -> Any:
    grouped = isinstance(value, list | tuple) and value and all(isinstance(item, list | tuple) for item in value)
    return value if grouped else [value]


_TEXTS, _COUNT, _SHARE = "a text or a list of texts", "a whole number of at least 1", "shares above 0, at most 1"
_One = BeforeValidator(_listed)
_Some = Field(min_length=1)
Text = Annotated[StrictStr, needs("a text")]
Texts = Annotated[tuple[StrictStr, ...], _Some, _One, needs(_TEXTS)]
TextGroups = Annotated[tuple[Texts, ...], BeforeValidator(_groups), needs(_TEXTS)]
Flag = Annotated[StrictBool, needs("true or false")]
Count = Annotated[int, Field(strict=True, ge=1), needs(_COUNT)]
Counts = Annotated[tuple[Count, ...], _Some, _One, needs(_COUNT)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False), needs("a positive number")]
Shares = Annotated[tuple[Annotated[float, Field(strict=True, gt=0.0, le=1.0)], ...], _Some, _One, needs(_SHARE)]


def read_yaml(path: Path, what: str) -> dict[str, Any]:
    """The mapping in a YAML file; `BadInput` where it is not YAML or, as `what` says, not the right kind of file."""
    import yaml

    try:
        content = yaml.safe_load(path.read_bytes())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise BadInput(f"is not YAML ({error})", file=path) from None
    if not isinstance(content, dict):
        raise BadInput(f"is not {what}", file=path)
    return content


def checked(model: type[Content], content: Any, place: object) -> Content:
    """`content` as an instance of `model`; `BadInput` names the place, the key and what is wrong with its value."""
    if not isinstance(content, dict):
        raise BadInput("is not a mapping", file=place)
    try:
        return model.model_validate(content)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
    key = " ".join(str(part) for part in fault["loc"])
    known = f"known: {', '.join(model.model_fields)}"
    if fault["type"] == "extra_forbidden":
        raise BadInput(f"unknown key {key!r}", file=place, hint=known)
    if fault["type"] == "missing":
        raise BadInput(f"missing: {key}", file=place, hint=known)
    message = fault["msg"].removeprefix("Value error, ")
    raise BadInput(f"{key}: {message}" if key else message, file=place)

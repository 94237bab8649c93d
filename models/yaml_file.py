"""Data files, checked against a pydantic model; every fault is one line with file and key.

Modules that declare such models are imported only where a file is read, so that the command line starts without
pydantic.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    ValidationError,
    WrapValidator,
)

from .data_file import load
from .errors import BadInput
from .suggestions import near

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
            shown = str(value).lower() if isinstance(value, bool) else shortened(value)
            raise ValueError(f"needs {words}, not {shown}") from None

    return WrapValidator(check)


def _listed(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else [value]


def _groups(value: Any) -> Any:
    grouped = isinstance(value, list | tuple) and value and all(isinstance(item, list | tuple) for item in value)
    return value if grouped else [value]


_TEXTS, _COUNT, _SHARE = "a text or a list of texts", "a whole number from 1 to 1000000", "shares above 0, at most 1"
_One = BeforeValidator(_listed)
_Some = Field(min_length=1)
Text = Annotated[StrictStr, needs("a text")]
Texts = Annotated[tuple[StrictStr, ...], _Some, _One, needs(_TEXTS)]
TextGroups = Annotated[tuple[Texts, ...], BeforeValidator(_groups), needs(_TEXTS)]
Flag = Annotated[StrictBool, needs("true or false")]
Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000), needs(_COUNT)]
Counts = Annotated[tuple[Count, ...], _Some, _One, needs(_COUNT)]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False), needs("a positive number")]
Shares = Annotated[tuple[Annotated[float, Field(strict=True, gt=0.0, le=1.0)], ...], _Some, _One, needs(_SHARE)]


Real = Annotated[StrictInt | StrictFloat, Field(allow_inf_nan=False), needs("a finite number")]
Side = Annotated[Literal["port", "starboard"], needs("port or starboard")]


class NumberWithUnit(FileContent):
    """A number with its unit; None where it is not known."""

    value: Real | None
    unit: Text


def read_yaml(path: str | Path, what: str) -> dict[Any, Any]:
    """The mapping in a YAML or JSON file; `BadInput` where it is neither, or not `what`."""
    content = load(path)
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
        faults = error.errors(include_url=False)
    fault = next((one for one in faults if one["type"] == "extra_forbidden"), faults[0])  # it may explain a missing key
    location = fault["loc"]
    key = shortened(" ".join(str(part) for part in location))
    if fault["type"] in ("extra_forbidden", "invalid_key"):
        raise BadInput(f"unknown key {key!r}", file=place, hint=_known(_keys_at(model, location), str(location[-1])))
    if fault["type"] == "missing":
        raise BadInput(f"missing: {key}", file=place, hint=_known(_keys_at(model, location)))
    message = fault["msg"].removeprefix("Value error, ")
    raise BadInput(f"{key}: {message}" if key else message, file=place)


def shortened(value: object, most: int = 80) -> str:
    """A value as a text for a message, cut to a sensible length."""
    text = str(value)
    return text if len(text) <= most else f"{text[: most - 3]}..."


def _known(keys: list[str], given: str = "") -> str:
    return f"{near(given, keys)} known: {', '.join(keys)}".lstrip()


def _keys_at(model: Any, location: tuple[int | str, ...]) -> list[str]:
    """Keys of the innermost model along a location in a file."""
    for part in location[:-1]:
        entry = model.model_fields.get(part) if isinstance(part, str) else None
        model = next((kind for kind in _models_in(entry.annotation)), model) if entry is not None else model
    return [field.alias or name for name, field in model.model_fields.items()]


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    """The pydantic models that a type names, `Gear | None` for example."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for part in get_args(annotation) for found in _models_in(part)]

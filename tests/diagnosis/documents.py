"""Documents of diagnoses against the JSON schema that is shipped."""

import json
from importlib.resources import files

from jsonschema import Draft202012Validator


def validator() -> Draft202012Validator:
    """The validator of diagnosis.json."""
    schema = json.loads((files("helmbench.diagnosis") / "diagnosis.schema.json").read_text("utf-8"))
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def faults(document: dict) -> list[str]:
    """What a document lacks, has too much or has of another type; read back from its JSON text."""
    read = json.loads(json.dumps(document, allow_nan=False))
    return [f"{error.json_path}: {error.message}" for error in validator().iter_errors(read)]

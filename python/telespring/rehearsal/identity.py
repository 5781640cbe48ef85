"""What identifies a rehearsal: study, user code, schema and version. Equal identities give equal datasets."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import telespring._core as core

__all__ = ["SCHEMA", "RehearsalIdentity", "core_version"]

#: Changes when a variable or attribute of the dataset changes its meaning or is removed.
SCHEMA = "telespring rehearsal 1"


@cache
def core_version() -> str:
    """Return the version of the compiled core with a hash of its build: another build may differ in numbers.

    The hash is computed on demand because it reads the whole core.
    """
    built = hashlib.sha256(Path(core.__file__).read_bytes()).hexdigest()
    return f"{core.__version__}+{built[:12]}"


@dataclass(frozen=True)
class RehearsalIdentity:
    """Everything that the numbers of a rehearsal depend on.

    Attributes
    ----------
    name
        Of the study, for messages.
    study
        The study's text.
    programs
        Agents and target written in Python: by their place in the study (such as ``agent1``), their name
        and a hash of their file.
    schema, version
        Of the dataset and of the core.
    """

    name: str
    study: str
    programs: dict[str, dict[str, str]]
    schema: str
    version: str

    @property
    def fingerprint(self) -> str:
        """A hash of the whole identity of a rehearsal."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    def to_json(self) -> str:
        """Return the identity as the text of a JSON file."""
        return json.dumps(asdict(self), sort_keys=True, ensure_ascii=False, indent=1)

    @classmethod
    def from_json(cls, text: str) -> RehearsalIdentity:
        """Read the output of `to_json`; ValueError if the text is something else."""
        attributes: Any = json.loads(text)
        try:
            return cls(**{key: attributes[key] for key in cls.__dataclass_fields__})
        except (KeyError, TypeError) as error:
            raise ValueError("not the identity of a rehearsal") from error

    def to_attributes(self) -> dict[str, str]:
        """Return the identity as attributes of a dataset."""
        return {
            "schema": self.schema,
            "telespring_version": self.version,
            "name": self.name,
            "study": self.study,
            "programs": json.dumps(self.programs, sort_keys=True, ensure_ascii=False),
        }

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, Any]) -> RehearsalIdentity:
        """Read the output of `to_attributes`; KeyError or ValueError if the attributes are others."""
        return cls(
            name=str(attributes["name"]),
            study=str(attributes["study"]),
            programs=json.loads(str(attributes["programs"])),
            schema=str(attributes["schema"]),
            version=str(attributes["telespring_version"]),
        )

    def describe_difference(self, other: RehearsalIdentity) -> str | None:
        """Describe how the rehearsal `other` differs from this one; None if it is the same."""
        if self == other:
            return None
        if other.schema != self.schema or other.version != self.version:
            return (
                f"a rehearsal by telespring {other.version} ({other.schema}); "
                f"this is {self.version} ({self.schema})"
            )
        if other.study != self.study:
            if other.name != self.name:
                return f"a rehearsal of another study, {other.name!r}"
            return f"a rehearsal of a study of the same name, {other.name!r}, with different contents"
        changed = sorted(
            place
            for place in self.programs.keys() | other.programs.keys()
            if self.programs.get(place) != other.programs.get(place)
        )
        return f"a rehearsal with another version of the Python file of {' and '.join(changed)}"

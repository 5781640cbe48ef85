"""What makes two rehearsals the same: study, programs in Python, schema and version."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from telespring import _core

__all__ = ["SCHEMA", "Identity", "version"]

#: Changes when a variable or attribute of the dataset changes its meaning or goes away.
SCHEMA = "telespring rehearsal 1"


@cache
def version() -> str:
    """Name the compiled core that computes, the build included: another build may give other numbers.

    Not what is installed beside it, and only where it is asked for: it reads the whole core.
    """
    built = hashlib.sha256(Path(_core.__file__).read_bytes()).hexdigest()
    return f"{_core.__version__}+{built[:12]}"


@dataclass(frozen=True)
class Identity:
    """All that the numbers of a rehearsal depend on.

    Attributes
    ----------
    name
        Of the study, for messages.
    study
        The study's text.
    programs
        Agents and target written in Python: per place in the study (such as ``agent1``) their name and
        a hash of the file they stand in.
    schema, version
        Of the dataset and of telespring.
    """

    name: str
    study: str
    programs: dict[str, dict[str, str]]
    schema: str
    version: str

    @property
    def fingerprint(self) -> str:
        """A hash of it all."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    def to_json(self) -> str:
        """Write it down."""
        return json.dumps(asdict(self), sort_keys=True, ensure_ascii=False, indent=1)

    @classmethod
    def from_json(cls, text: str) -> Identity:
        """Read what `to_json` wrote.

        Raises
        ------
        ValueError
            Where it is no such text.
        """
        found: Any = json.loads(text)
        try:
            return cls(**{key: found[key] for key in cls.__dataclass_fields__})
        except (KeyError, TypeError) as trouble:
            raise ValueError("no identity of a rehearsal") from trouble

    def to_attributes(self) -> dict[str, str]:
        """Write it as attributes of a dataset."""
        return {
            "schema": self.schema,
            "telespring_version": self.version,
            "name": self.name,
            "study": self.study,
            "programs": json.dumps(self.programs, sort_keys=True, ensure_ascii=False),
        }

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, Any]) -> Identity:
        """Read what `to_attributes` wrote.

        Raises
        ------
        KeyError, ValueError
            Where they are not such attributes.
        """
        return cls(
            name=str(attributes["name"]),
            study=str(attributes["study"]),
            programs=json.loads(str(attributes["programs"])),
            schema=str(attributes["schema"]),
            version=str(attributes["telespring_version"]),
        )

    def difference(self, other: Identity) -> str | None:
        """Say how the rehearsal `other`, found in a folder, differs from this one, or None."""
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
            return f"a rehearsal of a study of the same name, {other.name!r}, with other contents"
        changed = sorted(
            place
            for place in self.programs.keys() | other.programs.keys()
            if self.programs.get(place) != other.programs.get(place)
        )
        named = " and ".join(changed)
        return f"a rehearsal with another version of the Python file of {named}"

"""Settings in YAML: dataclasses whose fields state range, default and meaning; every error is reported at once."""

import dataclasses
import difflib
import math
import pathlib
import typing


class Rule(typing.NamedTuple):
    """What a value may be: its type, limits (both included) or choices, and meaning."""

    kind: str  # "number", "integer", "choice", "text", "flag", "names"
    text: str
    low: float = 0
    high: float = 0
    choices: tuple = ()

    def shown(self):
        """For help and errors."""
        if self.kind in ("number", "integer"):
            return f"{'a whole number' if self.kind == 'integer' else 'a number'} from {self.low:g} to {self.high:g}"
        return {"choice": "one of " + ", ".join(map(str, self.choices)), "text": "text", "flag": "true or false",
                "names": "a list of names"}[self.kind]

    def accepts(self, value):
        """Whether `value`, as YAML gives it, keeps the rule."""
        if self.kind in ("number", "integer"):
            if isinstance(value, bool) or not isinstance(value, int if self.kind == "integer" else (int, float)):
                return False
            return math.isfinite(value) and self.low <= value <= self.high
        if self.kind == "names":
            return isinstance(value, list) and all(isinstance(v, str) and v
                                                   for v in value) and len(set(value)) == len(value)
        return value in self.choices if self.kind == "choice" else isinstance(value, {
            "text": str,
            "flag": bool
        }[self.kind])


def _field(default, rule):
    if isinstance(default, list):
        return dataclasses.field(default_factory=lambda: list(default), metadata={"rule": rule})
    return dataclasses.field(default=default, metadata={"rule": rule})


def number(default, low, high, text):
    return _field(default, Rule("number", text, low, high))


def integer(default, low, high, text):
    return _field(default, Rule("integer", text, low, high))


def choice(default, choices, text):
    return _field(default, Rule("choice", text, choices=tuple(choices)))


def text(default, meaning):
    return _field(default, Rule("text", meaning))


def flag(default, meaning):
    return _field(default, Rule("flag", meaning))


def names(default, meaning):
    return _field(default, Rule("names", meaning))


def section(cls, meaning):
    """A nested group of settings."""
    return dataclasses.field(default_factory=cls, metadata={"section": cls, "text": meaning})


def read(cls, values, errors, prefix=""):
    """An object of the dataclass from a mapping; appends what is wrong to `errors` and keeps the default there."""
    if values is None:
        values = {}
    if not isinstance(values, dict):
        errors.append(f"{prefix.rstrip('.') or 'the file'} must be a mapping of keys to values")
        return cls()
    fields = {field.name: field for field in dataclasses.fields(cls)}
    taken = {}
    for key, value in values.items():
        field = fields.get(key)
        value = _number_of(field, value)
        if field is None:
            errors.append(f"{prefix}{key} is unknown{_suggestion(key, fields)}")
        elif "section" in field.metadata:
            taken[key] = read(field.metadata["section"], value, errors, f"{prefix}{key}.")
        elif not field.metadata["rule"].accepts(value):
            errors.append(f"{prefix}{key} must be {field.metadata['rule'].shown()}, not {value!r}")
        else:
            taken[key] = value
    return cls(**taken)


def _number_of(field, value):
    """YAML 1.1 reads 1e-3 as text, because it lacks a point: a number it is, where a number is expected."""
    if isinstance(value, str) and field is not None and "rule" in field.metadata and field.metadata["rule"].kind == "number":
        try:
            return float(value)
        except ValueError:
            pass
    return value


def _suggestion(key, fields):
    close = difflib.get_close_matches(str(key), fields, 1)
    return f"; did you mean {close[0]}?" if close else f"; known are {', '.join(fields)}"


def describe(cls, prefix=""):
    """Lines of help: every key with its default, what it may be and what it means."""
    lines = []
    for field in dataclasses.fields(cls):
        if "section" in field.metadata:
            lines += [f"{prefix}{field.name}: {field.metadata['text']}"]
            lines += describe(field.metadata["section"], prefix + "  ")
            continue
        rule = field.metadata["rule"]
        default = field.default if field.default is not dataclasses.MISSING else field.default_factory()
        shown = str(default).lower() if isinstance(default, bool) else str(default) if default != "" else '""'
        lines += [f"{prefix}{field.name}: {shown}", f"{prefix}    {rule.text} ({rule.shown()})"]
    return lines


def resolve(base, path):
    """An absolute path; a relative one counts from the folder of the settings file."""
    path = pathlib.Path(path).expanduser()
    return path if path.is_absolute() else (base / path).resolve()

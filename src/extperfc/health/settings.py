"""What the health node is set to: config/health.yaml and the names of the parts, checked as a whole."""

import dataclasses
import numbers
import re
import typing

from extperfc.health.processes import resolve

# Numbers of config/health.yaml and their ranges.
RANGES = {"look_period_s": (0.05, 5.0), "publish_period_s": (0.1, 60.0), "ping_period_s": (0.2, 60.0),
          "master_period_s": (0.5, 60.0), "start_s": (0.5, 600.0), "max_age_s": (0.2, 600.0), "hang_s": (1.0, 600.0),
          "unload_s": (0.1, 60.0), "max_restarts_per_minute": (0, 60)}
PART_RANGES = {name: RANGES[name] for name in ("start_s", "max_age_s", "hang_s")}
PART_KEYS = {"group", "node", "diagnostics", "ping", *PART_RANGES}


class Wrong(Exception):
    """Settings cannot be used; the text names every error."""


@dataclasses.dataclass(frozen=True)
class Part:
    """One supervised part: the ROS node `node`, its whole name; its diagnostics have names that match the regular expression
    `diagnostics`. ping: it has none, but its node must answer."""
    name: str
    group: str
    node: str
    diagnostics: str
    ping: bool
    start_s: float
    max_age_s: float
    hang_s: float


@dataclasses.dataclass(frozen=True)
class Settings:
    parts: typing.Tuple[Part, ...]
    look_period_s: float
    publish_period_s: float
    ping_period_s: float
    master_period_s: float
    unload_s: float
    max_restarts_per_minute: int


def _numbers(values, ranges, where, errors):
    """The numbers of `values` that are named in `ranges`; adds to errors what is out of its range."""
    found = {}
    for name, (low, high) in ranges.items():
        value = values.get(name)
        if isinstance(value, bool) or not isinstance(value, numbers.Real) or not low <= value <= high:
            errors.append(f"{where}{name} must be a number in [{low}, {high}], not {value}")
        found[name] = value
    return found


def _part(name, entry, namespace, defaults, errors):
    where = f"parts/{name}/"
    if not isinstance(entry, dict) or not isinstance(entry.get("group"), str) or not entry["group"]:
        errors.append(f"{where}group must name a group, e.g. {name}: {{group: Robot}}")
        return None
    errors.extend(f"{where}{key} is unknown" for key in sorted(set(entry) - PART_KEYS))
    limits = _numbers({**defaults, **entry}, PART_RANGES, where, errors)
    node = resolve(str(entry.get("node", name)), namespace)
    diagnostics = str(entry.get("diagnostics", rf"/?{re.escape(node[1:])}: .*"))
    try:
        re.compile(diagnostics)
    except re.error as error:
        errors.append(f"{where}diagnostics is no regular expression: {error}")
    return Part(name, entry["group"], node, diagnostics, bool(entry.get("ping", False)), **limits)


def _started(values, entries):
    """Names of the parts that were started: `started`, between commas, and the list `also`; all of them where both are empty."""
    named = [name.strip() for name in str(values.get("started", "")).split(",") if name.strip()]
    return list(dict.fromkeys([*named, *map(str, values.get("also") or [])])) or list(entries)


def load(values, namespace="/"):
    """Settings of the parameters of the node, a dict; its namespace is that of the parts. Raises Wrong."""
    errors = []
    errors.extend(f"{key} is unknown" for key in sorted(set(values) - {*RANGES, "parts", "started", "also"}))
    found = _numbers(values, RANGES, "", errors)
    entries = values.get("parts")
    entries = entries if isinstance(entries, dict) else {}
    started = _started(values, entries)
    errors.extend(f"started: parts has no {name}; add it there" for name in started if name not in entries)
    parts = [_part(name, entries[name], namespace, values, errors) for name in started if name in entries]
    if not parts:
        errors.append("parts has no part that was started")
    if errors:
        raise Wrong("; ".join(dict.fromkeys(errors)))
    return Settings(tuple(parts), **{name: value for name, value in found.items() if name not in PART_RANGES})

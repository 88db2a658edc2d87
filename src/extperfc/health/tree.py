"""The tree of diagnostics in the layout of diagnostic_aggregator: /<group>/<part>/<status>, and the summary of everything."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

from extperfc.health.part_state import ERROR, OK, STALE, WARN, State

LEVEL_NAMES = {OK: "OK", WARN: "Warning", ERROR: "Error", STALE: "Stale"}
OTHER = "Other"  # group of statuses that belong to no part


def _leaf(path, status):
    return DiagnosticStatus(level=status.level, name=f"{path}/{status.name.replace('/', ' ').strip()}", message=status.message,
                            hardware_id=status.hardware_id, values=status.values)


def _branch(path, children, level=None, message=None):
    """A status over its children, which is as bad as the worst of them."""
    level = max((child.level for child in children), default=OK) if level is None else level
    values = [KeyValue(key=child.name[len(path) + 1:], value=child.message) for child in children]
    return DiagnosticStatus(level=level, name=path, message=message or LEVEL_NAMES[level], values=values)


def _part(group, part, now):
    """(branch, leaves) of a part."""
    path = f"/{group}/{part.part.name}"
    leaves = [_leaf(path, status) for status in part.statuses(now)]
    return _branch(path, leaves, part.level(now), part.message(now)), leaves


def build(parts, others, now):
    """Statuses of the whole tree, parents first. others: statuses without a part."""
    statuses = []
    for group in dict.fromkeys(part.part.group for part in parts):
        found = [_part(group, part, now) for part in parts if part.part.group == group]
        statuses.append(_branch(f"/{group}", [branch for branch, _ in found]))
        for branch, leaves in found:
            statuses += [branch, *leaves]
    if others:
        leaves = [_leaf(f"/{OTHER}", status) for status in others]
        statuses += [_branch(f"/{OTHER}", leaves), *leaves]
    return statuses


def _names(title, parts):
    return [f"{title}: {', '.join(parts)}"] if parts else []


def summary(parts, now, complaint=""):
    """One status of the whole robot: a complaint about what is not of one part, which part refuses to start, is missing, silent, failing
    or starting, or warns, and each part's message."""
    states = {part.part.name: part.state(now) for part in parts}
    levels = {part.part.name: part.level(now) for part in parts}

    def named(state, level=None):
        return [name for name, found in states.items() if found is state and level in (None, levels[name])]

    complaints = [*filter(None, [complaint]), *_names("refuses to start", named(State.REFUSING)),
                  *_names("missing", named(State.MISSING)), *_names("silent", named(State.SILENT)),
                  *_names("failing", named(State.RUNNING, ERROR)), *_names("starting", named(State.STARTING)),
                  *_names("warning", named(State.RUNNING, WARN))]
    return DiagnosticStatus(level=ERROR if complaint else min(ERROR, max(levels.values())), name="robot",
                            message="; ".join(complaints) or f"all {len(parts)} parts run",
                            values=[KeyValue(key=part.part.name, value=part.message(now)) for part in parts])

"""A dict as TOML, in its own order, with arrays and numbers of numpy as plain ones."""

import json
import math
import re


def toml(scenario):
    """The text of a scenario."""
    lines = []
    _table([], scenario, lines)
    return "\n".join(lines) + "\n"


def _table(path, table, lines):
    """Writes what is no table first: after the head of a table, keys belong to that."""
    tables = []
    for key, value in table.items():
        value = _plain(value)
        if isinstance(value, dict) and len(path) < 2:
            tables.append((key, value))
        elif not path and _is_array_of_tables(value):
            tables.append((key, value))
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    for key, value in tables:
        inner = [*path, _key(key)]
        for one in value if isinstance(value, list) else [value]:
            head = ".".join(inner)
            lines.append(f"\n[[{head}]]" if isinstance(value, list) else f"\n[{head}]")
            _table(inner, one, lines)


def _is_array_of_tables(value):
    return isinstance(value, list) and value and all(isinstance(one, dict) for one in value)


def _plain(value):
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _key(key):
    if not isinstance(key, str):
        raise TypeError(f"the key {key!r} is no string")
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _string(key)


def _string(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value):
    value = _plain(value)
    if hasattr(value, "__fspath__"):
        value = value.__fspath__()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is not finite")
        return repr(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, list):
        return "[" + ", ".join(_value(one) for one in value) + "]"
    if isinstance(value, dict):
        inner = ", ".join(f"{_key(key)} = {_value(one)}" for key, one in value.items())
        return "{ " + inner + " }"
    raise TypeError(f"{type(value).__name__} has no place in a scenario")

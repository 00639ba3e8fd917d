#!/usr/bin/env python3
"""Checks an MCAP that `trolley report` wrote, with the format's own library and Foxglove's schemas.

    trolley demo --record decisions
    trolley report decisions/000000.record --mcap demo.mcap
    python3 -m venv venv && venv/bin/pip install mcap==1.6.0 foxglove-schemas-protobuf==0.4.0
    venv/bin/python tools/traces/check_mcap.py demo.mcap

The library checks every CRC and the summary. Each message must be a SceneUpdate of Foxglove with no
field that the schema does not know, of finite numbers, and triangles must be whole. Fails with exit
code 1 and the first fault; without these packages with exit code 2, never in silence.
"""

import json
import math
import sys

try:
    from foxglove_schemas_protobuf import SceneUpdate_pb2
    from google.protobuf import json_format
    from mcap.reader import make_reader
except ImportError as missing:
    print(f"NOT CHECKED: {missing}. pip install mcap foxglove-schemas-protobuf", file=sys.stderr)
    sys.exit(2)


def in_protobuf(value):
    """JSON of Foxglove has times as {sec, nsec}; that of protobuf as text."""
    if isinstance(value, list):
        return [in_protobuf(one) for one in value]
    if not isinstance(value, dict):
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"{value} is not finite")
        return value
    if set(value) == {"sec", "nsec"}:
        return f"{value['sec'] + value['nsec'] * 1e-9:.9f}s"
    # A point in time is seconds since 1970.
    return {
        key: f"1970-01-01T{one['sec'] // 3600:02}:{one['sec'] // 60 % 60:02}:{one['sec'] % 60:02}Z"
        if key == "timestamp"
        else in_protobuf(one)
        for key, one in value.items()
    }


def check(path):
    counts = {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages():
            assert schema.name == "foxglove.SceneUpdate", schema.name
            assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            said = json.loads(message.data)
            update = SceneUpdate_pb2.SceneUpdate()
            json_format.ParseDict(in_protobuf(said), update)
            assert update.entities, "nothing is drawn"
            for entity in update.entities:
                for triangles in entity.triangles:
                    corners = len(triangles.indices) or len(triangles.points)
                    assert corners % 3 == 0, f"{corners} corners are no whole triangles"
                for line in entity.lines:
                    assert len(line.points) > 1, "a line of one point"
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
    stated = summary.statistics.message_count
    assert stated == sum(counts.values()) > 0, f"{stated} messages stated, {counts} there"
    assert set(counts) == {"/crash", "/plan"}, counts
    print(f"{path}: sound; " + ", ".join(f"{n} on {topic}" for topic, n in sorted(counts.items())))


if __name__ == "__main__":
    try:
        for path in sys.argv[1:] or sys.exit(__doc__):
            check(path)
    except Exception as fault:
        print(f"{path}: {type(fault).__name__}: {fault}", file=sys.stderr)
        sys.exit(1)

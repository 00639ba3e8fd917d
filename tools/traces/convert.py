#!/usr/bin/env python3
"""Writes CommonRoad recordings as traces of ASAM OSI, with libraries that are not ours.

    python3 -m venv venv && venv/bin/pip install osi-python==3.8.0 mcap-protobuf-support==0.6.0
    venv/bin/python tools/traces/convert.py OUT_FOLDER FILE.xml ...

One file each: a third as GroundTruth (.osi), a third as SensorView (.osi), a third as GroundTruth
in MCAP. The host vehicle is the first obstacle that moves. Of every recording the first 100 steps
are written; states that are intervals or have no heading end it. Recordings of one obstacle are left
out. `cargo x inputs` reads what this writes.
"""

import math
import pathlib
import struct
import sys
import xml.etree.ElementTree as ET

from mcap_protobuf.writer import Writer
from osi3 import osi_groundtruth_pb2, osi_object_pb2, osi_sensorview_pb2

STEPS_MAX = 100
OBJECTS_MAX = 60

Moving = osi_object_pb2.MovingObject
Vehicle = Moving.VehicleClassification
VEHICLES = {
    "car": Vehicle.TYPE_MEDIUM_CAR,
    "taxi": Vehicle.TYPE_MEDIUM_CAR,
    "priorityVehicle": Vehicle.TYPE_DELIVERY_VAN,
    "parkedVehicle": Vehicle.TYPE_MEDIUM_CAR,
    "truck": Vehicle.TYPE_HEAVY_TRUCK,
    "bus": Vehicle.TYPE_BUS,
    "motorcycle": Vehicle.TYPE_MOTORBIKE,
    "bicycle": Vehicle.TYPE_BICYCLE,
}
HEIGHTS_M = {"truck": 3.2, "bus": 3.1, "pedestrian": 1.75, "bicycle": 1.7, "motorcycle": 1.5}


def exact(state, name):
    value = state.find(f"{name}/exact")
    return None if value is None else float(value.text)


def read(path):
    """Step in seconds, and of each obstacle that moves: id, type, size, states by step."""
    root = ET.parse(path).getroot()
    if root.tag != "commonRoad":
        raise ValueError("not CommonRoad")
    obstacles = []
    for element in root:
        if element.tag not in ("obstacle", "dynamicObstacle") or element.find("trajectory") is None:
            continue
        box, disc = element.find("shape/rectangle"), element.find("shape/circle/radius")
        if box is not None:
            size = [float(box.findtext("length")), float(box.findtext("width"))]
        elif disc is not None:
            size = [2 * float(disc.text)] * 2
        else:
            continue
        states = {}
        for state in [element.find("initialState"), *element.findall("trajectory/state")]:
            point = state.find("position/point")
            numbers = [exact(state, name) for name in ("time", "orientation", "velocity")]
            if point is None or None in numbers:
                break
            x, y = float(point.findtext("x")), float(point.findtext("y"))
            states[int(numbers[0])] = (x, y, numbers[1], numbers[2])
        if len(states) > 1:
            obstacles.append((int(element.get("id")), element.findtext("type"), size, states))
    return float(root.get("timeStepSize")), obstacles[:OBJECTS_MAX]


def truths(step_s, obstacles):
    host = obstacles[0]
    first = min(host[3])
    for step in sorted(host[3])[:STEPS_MAX]:
        truth = osi_groundtruth_pb2.GroundTruth()
        truth.version.version_major = 3
        truth.version.version_minor = 8
        nanos = round((step - first) * step_s * 1e9)
        truth.timestamp.seconds, truth.timestamp.nanos = divmod(nanos, 10**9)
        truth.host_vehicle_id.value = host[0]
        for number, kind, size, states in obstacles:
            if step not in states:
                continue
            x, y, yaw, speed = states[step]
            one = truth.moving_object.add()
            one.id.value = number
            height = HEIGHTS_M.get(kind, 1.5)
            base = one.base
            base.dimension.length, base.dimension.width, base.dimension.height = *size, height
            base.position.x, base.position.y, base.position.z = x, y, height / 2
            base.orientation.yaw = yaw
            base.velocity.x, base.velocity.y = speed * math.cos(yaw), speed * math.sin(yaw)
            if kind == "pedestrian":
                one.type = Moving.TYPE_PEDESTRIAN
            else:
                one.type = Moving.TYPE_VEHICLE
                vehicle = VEHICLES.get(kind, Vehicle.TYPE_MEDIUM_CAR)
                one.vehicle_classification.type = vehicle
        yield truth


def main():
    out = pathlib.Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    written = 0
    names = set()
    for path in map(pathlib.Path, sys.argv[2:]):
        try:
            step_s, obstacles = read(path)
        except (ValueError, ET.ParseError, AttributeError, TypeError):
            continue
        if len(obstacles) < 2:
            continue
        # Collections hold recordings of the same name.
        name, number = path.stem, 2
        while name in names:
            name, number = f"{path.stem}-{number}", number + 1
        names.add(name)
        if written % 3 == 2:
            with open(out / f"{name}.mcap", "wb") as file, Writer(file) as writer:
                for truth in truths(step_s, obstacles):
                    at = truth.timestamp.seconds * 10**9 + truth.timestamp.nanos
                    writer.write_message("GroundTruth", truth, at, at)
        else:
            with open(out / f"{name}.osi", "wb") as file:
                for truth in truths(step_s, obstacles):
                    message = truth
                    if written % 3 == 1:
                        message = osi_sensorview_pb2.SensorView()
                        message.timestamp.CopyFrom(truth.timestamp)
                        message.host_vehicle_id.CopyFrom(truth.host_vehicle_id)
                        message.global_ground_truth.CopyFrom(truth)
                    data = message.SerializeToString()
                    file.write(struct.pack("<I", len(data)) + data)
        written += 1
    print(f"{written} traces in {out}")


if __name__ == "__main__":
    main()

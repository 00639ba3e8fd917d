#!/usr/bin/env python3
"""Writes the traces of config/examples with a library that is not ours.

    python3 -m venv venv && venv/bin/pip install betterosi==0.9.0
    venv/bin/python tools/traces/write.py

Three scenes, of which every motion is a formula; tests/files/traces.rs has their twins, written by
hand. The messages are those of betterosi, which reads and writes ASAM OSI; the CSV has the columns
that esmini writes with --csv_logger. The files are the same each time, but for a date in the MCAP.
"""

import math
import pathlib

import betterosi as osi
from mcap.writer import CompressionType

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "config/examples"

Vehicle = osi.MovingObject.VehicleClassification.Type
Fixed = osi.StationaryObject.Classification.Type
START_S = 100  # simulators do not begin at 0


def moving(number, kind, size, state, vehicle=None):
    x, y, yaw, vx, vy = state
    about = {}
    if vehicle is not None:
        about["vehicle_classification"] = osi.MovingObject.VehicleClassification(type=vehicle)
    return osi.MovingObject(
        id=osi.Identifier(value=number),
        type=kind,
        base=osi.BaseMoving(
            dimension=osi.Dimension3d(length=size[0], width=size[1], height=size[2]),
            position=osi.Vector3d(x=x, y=y, z=size[2] / 2),
            orientation=osi.Orientation3d(roll=0.0, pitch=0.0, yaw=yaw),
            velocity=osi.Vector3d(x=vx, y=vy, z=0.0),
        ),
        **about,
    )


def standing(number, kind, size, x, y):
    return osi.StationaryObject(
        id=osi.Identifier(value=number),
        base=osi.BaseStationary(
            dimension=osi.Dimension3d(length=size[0], width=size[1], height=size[2]),
            position=osi.Vector3d(x=x, y=y, z=size[2] / 2),
            orientation=osi.Orientation3d(roll=0.0, pitch=0.0, yaw=0.0),
        ),
        classification=osi.StationaryObject.Classification(type=kind),
    )


def time(step, rate):
    return osi.Timestamp(seconds=START_S + step // rate, nanos=step % rate * (10**9 // rate))


def crossing(t):
    """12 m/s, and 3 m/s² of braking from 1 s on; somebody crosses; a van comes the other way."""
    late = max(t - 1.0, 0.0)
    ego = (12.0 * t - 1.5 * late**2, 0.0, 0.0, 12.0 - 3.0 * late, 0.0)
    walker = (26.0, -4.0 + 1.4 * t, math.pi / 2, 0.0, 1.4)
    van = (70.0 - 10.0 * t, 3.5, math.pi, -10.0, 0.0)
    return ego, walker, van


def ground_truth(t, timestamp):
    ego, walker, van = crossing(t)
    return osi.GroundTruth(
        timestamp=timestamp,
        host_vehicle_id=osi.Identifier(value=7),
        moving_object=[
            moving(7, osi.MovingObject.Type.VEHICLE, (4.8, 1.9, 1.45), ego, Vehicle.CAR),
            moving(11, osi.MovingObject.Type.PEDESTRIAN, (0.4, 0.6, 1.75), walker),
            moving(12, osi.MovingObject.Type.VEHICLE, (5.2, 2.0, 1.9), van, Vehicle.DELIVERY_VAN),
        ],
        stationary_object=[
            standing(20, Fixed.POLE, (0.3, 0.3, 5.0), 30.0, -3.0),
            standing(21, Fixed.BRIDGE, (10.0, 40.0, 1.0), 60.0, 0.0),
        ],
    )


def merge(t):
    """A lane change over 2 s, behind a car that brakes; a motorcycle keeps to its lane."""
    share = min(t / 2.0, 1.0)
    y = 3.5 * (3 * share**2 - 2 * share**3)
    vy = 3.5 * 6 * (share - share**2) / 2.0
    ego = (15.0 * t, y, math.atan2(vy, 15.0), 15.0, vy)
    stop = min(t, 13.0 / 5.0)
    car = (22.0 + 13.0 * stop - 2.5 * stop**2, 3.5, 0.0, 13.0 - 5.0 * stop, 0.0)
    motorcycle = (-12.0 + 14.0 * t, -0.5, 0.0, 14.0, 0.0)
    return ego, car, motorcycle


def sensor_view(t, timestamp):
    ego, car, motorcycle = merge(t)
    vehicle = osi.MovingObject.Type.VEHICLE
    truth = osi.GroundTruth(
        timestamp=timestamp,
        moving_object=[
            moving(5, vehicle, (4.6, 1.8, 1.75), car, Vehicle.CAR),
            moving(3, vehicle, (4.5, 1.85, 1.5), ego, Vehicle.COMPACT_CAR),
            moving(9, vehicle, (2.2, 0.8, 1.5), motorcycle, Vehicle.MOTORBIKE),
        ],
    )
    host = osi.Identifier(value=3)
    return osi.SensorView(timestamp=timestamp, global_ground_truth=truth, host_vehicle_id=host)


COLUMNS = [
    "Entity_Name [-]", "Entity_ID [-]", "Current_Speed [m/s]", "Wheel_Angle [deg]",
    "Wheel_Rotation [-]", "bb_x [m]", "bb_y [m]", "bb_z [m]", "bb_length [m]", "bb_width [m]",
    "bb_height [m]", "World_Position_X [m]", "World_Position_Y [m]", "World_Position_Z [m]",
    "Vel_X [m/s]", "Vel_Y [m/s]", "Vel_Z [m/s]", "Acc_X [m/s2]", "Acc_Y [m/s2]", "Acc_Z [m/s2]",
    "Distance_Travelled_Along_Road_Segment [m]", "Lateral_Distance_Lanem [m]", "lane_id",
    "lane_offset [m]", "World_Heading_Angle [rad]", "Heading_Angle_Rate [rad/s]",
    "Relative_Heading_Angle [rad]", "Relative_Heading_Angle_Drive_Direction [rad]",
    "World_Pitch_Angle [rad]", "Road_Curvature [1/m]", "collision_ids",
]


def entity(name, number, speed, box, middle, x, y, yaw, rate):
    """The reference point is `middle` metres behind the middle of the box."""
    x, y = x - middle * math.cos(yaw), y - middle * math.sin(yaw)
    vx = speed * math.cos(yaw) + middle * rate * math.sin(yaw)
    vy = speed * math.sin(yaw) - middle * rate * math.cos(yaw)
    numbers = [speed, 0, 0, middle, 0, box[2] / 2, *box, x, y, 0, vx, vy, 0, 0, 0, 0, 0, 0]
    fields = [f"{value:.6f}" for value in numbers]
    more = ["0", *(f"{value:.6f}" for value in (0, yaw, rate, 0, 0, 0, 0)), ""]
    return [name, str(number), *fields, *more]


def junction(t):
    """The ego turns left, 6 m/s on a radius of 12 m; a car comes; a bicycle stands."""
    turn = 6.0 / 12.0
    yaw = turn * t
    ego = (12.0 * math.sin(yaw), 12.0 - 12.0 * math.cos(yaw), yaw)
    return [
        entity("Ego", 0, 6.0, (5.04, 2.0, 1.5), 1.4, *ego, turn),
        entity("Oncoming", 1, 8.0, (4.5, 1.8, 1.4), 1.3, 28.0 - 8.0 * t, 3.0, math.pi, 0.0),
        entity("Waiting", 2, 0.0, (1.8, 0.6, 1.7), 0.0, 12.0, 13.0, -math.pi / 2, 0.0),
    ]


def csv(path, steps, rate):
    names = ["Index [-]", "TimeStamp [s]"]
    names += [f"#{number} {column}" for number in (1, 2, 3) for column in COLUMNS]
    lines = ["Version: esmini's columns, written by tools/traces/write.py", ", ".join(names) + ","]
    for step in range(steps):
        fields = [str(step), f"{step / rate:.3f}"]
        for fields_of_one in junction(step / rate):
            fields += fields_of_one
        lines.append(", ".join(fields) + ",")
    path.write_text("\n".join(lines) + "\n")


def main():
    with osi.Writer(EXAMPLES / "crossing.osi") as writer:
        for step in range(61):
            writer.add(ground_truth(step / 20, time(step, 20)))
    # Without the description of the messages, which would be most of the file.
    about = {"descriptor_set": b"", "compression": CompressionType.ZSTD}
    with osi.Writer(EXAMPLES / "merge.mcap", **about) as writer:
        for step in range(81):
            writer.add(sensor_view(step / 25, time(step, 25)), topic="view")
    csv(EXAMPLES / "junction.csv", 46, 15)


if __name__ == "__main__":
    main()

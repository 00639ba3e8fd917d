"""Makes bodies, queries and rankings over and over, and fails if the process keeps growing.

    python leaks.py --bodies 100000
"""

import argparse
import gc
import sys

import numpy as np
import shapes

import trolley_av as ta


def resident_kb():
    """Memory of this process that is in use (kB)."""
    with open("/proc/self/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def once(number, session, scenario, poses):
    """Everything that allocates, once."""
    a, b = ta.Body(*shapes.BALL), ta.Body(shapes.SOUP)
    ta.hits(a, b, poses)
    ta.segments(a, b)
    ta.pairs(a, b).tolist()
    ta.first_contact(a, b, poses, [1, 0, 0], 2.0)
    ta.Scene([a, b]).pairs(poses[:2])
    try:
        ta.Body([[0, 0, float("nan")]], [[0, 0, 0]])
    except ta.InputError:
        pass
    if number % 100 == 0:
        session.rank(scenario).answer


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bodies", type=int, default=100_000)
    bodies = parser.parse_args().bodies
    shapes.BALL, shapes.SOUP = shapes.ball(6, 8), shapes.soup(40, 0.5, 1)
    poses = shapes.poses(3, 1.0, 2)
    scenario = ta.Scenario.parse(SCENARIO)
    session = ta.Session()
    rounds = bodies // 2
    sizes = []
    for number in range(rounds):
        once(number, session, scenario, poses)
        if number % (rounds // 10) == rounds // 10 - 1:
            gc.collect()
            sizes.append(resident_kb())
    growth = sizes[-1] - sizes[2]
    print(f"{2 * rounds} bodies: {sizes} kB after each tenth, {growth} kB more since the third")
    # A byte per body would be 70 kB; pages of the allocator come and go.
    sys.exit(growth > 4_000)


SCENARIO = """
schema = "trolley.scenario/2"
name = "Pole"
[parties]
ego = { generate = { shape = "sedan", triangles = 1500 } }
[parties.pole]
generate = { shape = "pole", triangles = 600 }
place = { position_m = [12, -0.5, 0] }
[[candidates]]
name = "straight on"
state = { position_m = [0, 0, 0], speed_m_s = 9 }
"""

if __name__ == "__main__":
    main()

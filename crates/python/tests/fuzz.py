"""Random calls with random arguments: each returns what it should, or raises an exception that says
why. Nothing else happens: no crash, no panic.

    python fuzz.py --calls 1000000 --seed 1
"""

import argparse
import sys

import numpy as np
import shapes

import trolley_av as ta

DTYPES = ["f2", "f4", "f8", ">f8", "g", "i1", "i4", "i8", "u1", "u8", "b1", "c16", "O", "U3", "M8[s]"]
SPECIAL = [0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e-45, 1e-310, 1e38, 1e39, 1e300, 2.0**31]


class Fuzzer:
    """A source of arguments, some of them sensible."""

    def __init__(self, seed):
        self.random = np.random.default_rng(seed)
        small = [shapes.soup(3, 1.0, 1), shapes.lattice(4, 2), shapes.lattice(1, 3)]
        self.bodies = [ta.Body(corners) for corners in small]
        self.scenario = "schema = \"trolley.scenario/2\"\nname = \"x\"\n"

    def chance(self, share):
        return self.random.random() < share

    def pick(self, options):
        return options[self.random.integers(len(options))]

    def array(self, shape):
        """An array of about this shape, of any type, with special values, strided or not."""
        shape = [max(0, n + int(self.random.integers(-1, 2))) if self.chance(0.05) else n
                 for n in shape]
        if self.chance(0.03):
            shape = shape[:-1]
        if self.chance(0.03):
            shape = [1, *shape]
        values = self.random.integers(-2, 4, shape).astype(float)
        for _ in range(self.random.integers(0, 3)):
            if values.size:
                values.flat[self.random.integers(values.size)] = self.pick(SPECIAL)
        with np.errstate(all="ignore"):
            if self.chance(0.6):
                array = values
            else:
                try:
                    array = values.astype(self.pick(DTYPES))
                except (ValueError, TypeError):
                    array = values
        if self.chance(0.2) and array.ndim:
            array = np.repeat(array, 2, axis=-1)[..., ::2]
        if self.chance(0.1) and array.ndim:
            array = array[::-1]
        if self.chance(0.1):
            array = np.asfortranarray(array)
        if self.chance(0.1):
            array.flags.writeable = False
        if self.chance(0.05):
            array = array.tolist()
        return array

    def anything(self):
        return self.pick([None, 1, -1, 2**70, 1.5, "text", b"bytes", [], {}, object(), (1, 2), True])

    def body(self):
        return self.anything() if self.chance(0.02) else self.pick(self.bodies)

    def poses(self):
        if self.chance(0.02):
            return self.anything()
        count = int(self.random.integers(0, 4))
        if self.chance(0.3):
            return self.array([count, 4, 4])
        poses = np.tile(np.eye(4), (count, 1, 1))
        poses[:, :3, 3] = self.random.integers(-2, 3, (count, 3))
        for pose in poses:
            if self.chance(0.5):
                pose[:3, :3] = shapes.rotation(self.random)
        if count and self.chance(0.05):
            poses[0, self.random.integers(4), self.random.integers(4)] = self.pick(SPECIAL)
        return poses

    def made_body(self):
        if self.chance(0.3):
            return ta.Body(self.array([int(self.random.integers(0, 4)), 3, 3]))
        vertices = self.array([int(self.random.integers(0, 6)), 3])
        faces = self.random.integers(-1 if self.chance(0.1) else 0, 6,
                                     (int(self.random.integers(0, 5)), 3))
        if self.chance(0.2):
            faces = self.array([3, 3])
        body = ta.Body(vertices, faces, leaf_size=self.pick([None, 1, 4, 0, 2**31]))
        if self.chance(0.02):
            self.bodies[int(self.random.integers(3))] = body
        return body

    def threads(self):
        return self.pick([1, 1, 1, 1, 2, 0, 257, -1])

    def scene(self):
        bodies = [self.body() for _ in range(self.random.integers(0, 4))]
        return ta.Scene(bodies).pairs(self.poses())

    def first_contact(self):
        count = int(self.random.integers(0, 4))
        direction = self.array([3]) if self.chance(0.7) else self.array([count, 3])
        return ta.first_contact(self.body(), self.body(), self.poses(), direction,
                                self.pick([*SPECIAL, 5.0, 5.0, 5.0]),
                                start=self.pick([0.0, 0.0, *SPECIAL]), threads=self.threads())

    def parsed(self):
        noise = "".join(self.pick(["[", "]", "=", "parties", "\n", "1", "\"", ".", "{", "\x00", "é"])
                        for _ in range(self.random.integers(0, 20)))
        return ta.Scenario.parse(self.scenario + noise)

    def call(self):
        """Makes one call; what it returns is looked at, so that all of it was really made."""
        which = self.random.integers(100)
        if which < 25:
            return len(self.made_body().triangles)
        if which < 45:
            return ta.touches(self.body(), self.body(), self.poses(), threads=self.threads()).sum()
        if which < 60:
            return ta.pairs(self.body(), self.body(), self.poses()).sum()
        if which < 70:
            return ta.hits(self.body(), self.body(), self.poses(), threads=self.threads())[1].sum()
        if which < 80:
            return ta.segments(self.body(), self.body(), self.poses()).points.sum()
        if which < 88:
            return self.first_contact().travel.sum()
        if which < 92:
            return ta.self_pairs(self.body()).sum()
        if which < 97:
            return self.scene().sum()
        return len(self.parsed().text)


def run(calls, seed):
    """Makes so many calls; returns how many were refused."""
    fuzzer = Fuzzer(seed)
    refused = 0
    with np.errstate(all="ignore"):
        for number in range(calls):
            try:
                fuzzer.call()
            except (ta.TrolleyError, TypeError, OverflowError) as refusal:
                refused += 1
                assert str(refusal), f"call {number} of seed {seed} says nothing"
            except BaseException:
                print(f"call {number} of seed {seed}", file=sys.stderr)
                raise
    return refused


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--calls", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    refused = run(asked.calls, asked.seed)
    print(f"{asked.calls} calls of seed {asked.seed}: {refused} refused, no crash")

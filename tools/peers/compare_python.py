"""The Python package beside other libraries that pip installs: what is right, and what is quick.

    python compare_python.py TROLLEY TESTS

Prints a page in Markdown. Everything runs on one core, in turns; times are of the processor, medians
over the rounds. `cargo x wheel --compare` calls it in an environment that has the libraries.
"""

import importlib.metadata
import json
import os
import resource
import statistics
import subprocess
import sys
import time

TROLLEY, TESTS = sys.argv[1:3]
sys.path.insert(0, TESTS)
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import numpy as np  # noqa: E402
import oracle  # noqa: E402
import shapes  # noqa: E402

import trolley_av as ta  # noqa: E402

ROUNDS = 3
"""Rounds of the two threads: they take milliseconds, and any other process is in the way."""
THREAD_ROUNDS = 21
POSES = 10_000
"""How long a round of a library may take (s): slow ones take the first poses alone."""
LIMIT_S = 1.0


def welded(triangles):
    """Vertices float64[n, 3] and faces int32[m, 3] of corners."""
    flat = triangles.reshape(-1, 3)
    vertices, inverse = np.unique(flat, axis=0, return_inverse=True)
    return vertices.astype(float), inverse.reshape(-1, 3).astype(np.int32)


class Ours:
    name, package = "trolley_av", "trolley-av"
    says = "`touches`, one call"

    def __init__(self, a, b):
        self.a, self.b = ta.Body(a), ta.Body(b)

    def touches(self, poses):
        return ta.touches(self.a, self.b, poses)

    def pairs(self, pose):
        return ta.pairs(self.a, self.b, pose).tolist()


class OneByOne(Ours):
    name = "trolley_av, one by one"
    says = "`touches`, one call for each pose"

    def touches(self, poses):
        return np.array([ta.touches(self.a, self.b, pose)[0] for pose in poses])


class Fcl:
    name, package = "python-fcl", "python-fcl"
    says = "`collide` of two `BVHModel`"

    def __init__(self, a, b):
        import fcl

        self.fcl = fcl
        models = []
        for triangles in (a, b):
            vertices, faces = welded(triangles)
            model = fcl.BVHModel()
            model.beginModel(len(vertices), len(faces))
            model.addSubModel(vertices, faces)
            model.endModel()
            models.append(model)
        self.fixed, self.moved = (fcl.CollisionObject(model, fcl.Transform()) for model in models)

    def touches(self, poses):
        fcl, found = self.fcl, []
        for pose in poses:
            self.moved.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
            request, result = fcl.CollisionRequest(), fcl.CollisionResult()
            found.append(fcl.collide(self.fixed, self.moved, request, result) > 0)
        return np.array(found)

    def pairs(self, pose):
        fcl = self.fcl
        self.moved.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        request = fcl.CollisionRequest(num_max_contacts=1_000_000, enable_contact=True)
        result = fcl.CollisionResult()
        fcl.collide(self.fixed, self.moved, request, result)
        return sorted({(contact.b1, contact.b2) for contact in result.contacts})


class Trimesh:
    name, package = "trimesh", "trimesh"
    says = "`CollisionManager.in_collision_internal`, which asks python-fcl"

    def __init__(self, a, b):
        import trimesh

        a, b = (trimesh.Trimesh(*welded(one), process=False) for one in (a, b))
        self.manager = trimesh.collision.CollisionManager()
        self.manager.add_object("a", a)
        self.manager.add_object("b", b)

    def touches(self, poses):
        found = []
        for pose in poses:
            self.manager.set_transform("b", pose)
            found.append(self.manager.in_collision_internal())
        return np.array(found)

    pairs = None


class Coal:
    name, package = "coal", "coal"
    says = "`collide` of two `BVHModelOBBRSS`"

    def __init__(self, a, b):
        import coal

        self.coal = coal
        self.models = []
        for triangles in (a, b):
            vertices, faces = welded(triangles)
            model = coal.BVHModelOBBRSS()
            model.beginModel(len(faces), len(vertices))
            model.addVertices(vertices)
            model.addTriangles(faces.astype(np.int64))
            model.endModel()
            self.models.append(model)

    def ask(self, pose, request):
        coal = self.coal
        moved = coal.Transform3s(np.ascontiguousarray(pose[:3, :3]), pose[:3, 3])
        result = coal.CollisionResult()
        coal.collide(self.models[0], coal.Transform3s(), self.models[1], moved, request, result)
        return result

    def touches(self, poses):
        request = self.coal.CollisionRequest()
        return np.array([self.ask(pose, request).isCollision() for pose in poses])

    def pairs(self, pose):
        request = self.coal.CollisionRequest(self.coal.CollisionRequestFlag.CONTACT, 1_000_000)
        contacts = self.ask(pose, request).getContacts()
        return sorted({(contact.b1, contact.b2) for contact in contacts})


class Trueform:
    name, package = "trueform", "trueform"
    says = "`intersects` of two meshes"

    def __init__(self, a, b):
        import trueform

        self.trueform = trueform
        meshes = []
        for triangles in (a, b):
            vertices, faces = welded(triangles)
            meshes.append(trueform.Mesh(faces, vertices))
        self.fixed, self.moved = meshes

    def touches(self, poses):
        found = []
        for pose in poses:
            self.moved.transformation = pose
            found.append(bool(self.trueform.intersects(self.fixed, self.moved)))
        return np.array(found)

    def pairs(self, pose):
        self.moved.transformation = pose
        found = self.trueform.gather_intersecting_ids(self.fixed, self.moved)
        return sorted(map(tuple, np.asarray(found).tolist()))


class Meshlib:
    name, package = "meshlib", "meshlib"
    says = "`findCollidingTriangles`, the first only; float32"

    def __init__(self, a, b):
        from meshlib import mrmeshnumpy, mrmeshpy

        self.lib = mrmeshpy
        # Faces that do not fit together stay apart, so that numbers of triangles are kept.
        def mesh(triangles):
            faces = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
            return mrmeshnumpy.meshFromFacesVerts(faces, triangles.reshape(-1, 3))

        self.meshes = [mesh(one) for one in (a, b)]
        self.parts = [mrmeshpy.MeshPart(one) for one in self.meshes]

    def placed(self, pose):
        rows = [self.lib.Vector3f(*map(float, row)) for row in pose[:3, :3]]
        at = self.lib.Vector3f(*map(float, pose[:3, 3]))
        return self.lib.AffineXf3f(self.lib.Matrix3f(*rows), at)

    def touches(self, poses):
        find = self.lib.findCollidingTriangles
        return np.array([len(find(*self.parts, self.placed(pose), True)) > 0 for pose in poses])

    def pairs(self, pose):
        found = self.lib.findCollidingTriangles(*self.parts, self.placed(pose), False)
        return sorted((pair.aFace.get(), pair.bFace.get()) for pair in found)


class Open3d:
    name, package = "open3d", "open3d"
    says = "`is_intersecting` of two meshes, one of them transformed; each against each"

    def __init__(self, a, b):
        import open3d

        def mesh(triangles):
            vertices, faces = welded(triangles)
            return open3d.geometry.TriangleMesh(
                open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces)
            )

        self.copy = open3d.geometry.TriangleMesh
        self.fixed, self.moved = mesh(a), mesh(b)

    def touches(self, poses):
        found = []
        for pose in poses:
            found.append(self.fixed.is_intersecting(self.copy(self.moved).transform(pose)))
        return np.array(found)

    pairs = None


PEERS = [Ours, OneByOne, Fcl, Trimesh, Coal, Trueform, Meshlib, Open3d]


def available():
    """The libraries that are there, and why others are not."""
    there, missing = [], []
    small = shapes.soup(4, 1.0, 1)
    for peer in PEERS:
        try:
            peer(small, small).touches(np.eye(4)[None])
            there.append(peer)
        except Exception as error:  # noqa: BLE001: whatever a foreign library raises
            missing.append(f"{peer.name}: {type(error).__name__}: {str(error)[:90]}")
    return there, missing


def version(peer):
    try:
        return importlib.metadata.version(peer.package)
    except importlib.metadata.PackageNotFoundError:
        return "?"


def row(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def time_of(value):
    """A time (s) in three digits."""
    for unit, scale in (("s", 1.0), ("ms", 1e3), ("µs", 1e6)):
        if value * scale >= 1:
            break
    return f"{value * scale:.3g} {unit}"


def spent(call):
    begun = time.process_time()
    answer = call()
    return answer, time.process_time() - begun


HARD = {
    "spread": (shapes.soup(24, 0.5, 21), shapes.soup(24, 0.5, 22), shapes.poses(120, 1.6, 23)),
    "touching": (
        shapes.lattice(4, 24, 3), shapes.lattice(4, 25, 3),
        np.stack([shapes.moved(x, y, z) for x in range(-3, 4) for y in range(-3, 4)
                  for z in (-3, -2, 0, 2)]),
    ),
    "flat": (
        shapes.lattice(3, 26, 4) * [1, 1, 0], shapes.lattice(3, 27, 4) * [1, 1, 0],
        np.stack([shapes.moved(x / 2, y / 2, z) for x in range(-8, 9, 2)
                  for y in range(-8, 9, 2) for z in (0, 2.0**-30)]),
    ),
    "far away": (
        shapes.soup(16, 0.5, 28) + np.float32(1024), shapes.soup(16, 0.5, 29),
        np.stack([shapes.moved(1024 + x, 1024 + y, 1024)
                  for x in np.linspace(-2, 2, 11) for y in np.linspace(-2, 2, 11)]),
    ),
}


def right(peers):
    print("## Right\n")
    print("Small bodies, at poses of which exact rational arithmetic, each triangle against each, "
          "says whether they touch: `spread` in general position, `touching` with whole "
          "coordinates, so that corners, edges and faces meet exactly, `flat` in one plane and "
          "2⁻³⁰ m above it, `far away` 1,024 m from the origin. Wrong answers, of all poses; then, "
          "where a library lists pairs, poses at which its list is wrong.\n")
    row("library", *[f"`{name}`" for name in HARD], *[f"pairs of `{name}`" for name in HARD])
    row("---", *["--:"] * (2 * len(HARD)))
    truths = {}
    for name, (a, b, poses) in HARD.items():
        a, b = np.float32(a), np.float32(b)
        truths[name] = [[tuple(pair) for pair in oracle.pairs(a, b, pose)] for pose in poses]
    for peer in peers:
        if peer is OneByOne:
            continue
        cells, lists = [], []
        for name, (a, b, poses) in HARD.items():
            there = peer(np.float32(a), np.float32(b))
            truth = truths[name]
            found = there.touches(poses)
            wrong = sum(bool(x) != bool(y) for x, y in zip(found, truth))
            cells.append(f"{wrong} of {len(poses)}")
            if there.pairs is None:
                lists.append("–")
                continue
            wrong = sum([tuple(p) for p in there.pairs(pose)] != pairs
                        for pose, pairs in zip(poses, truth))
            lists.append(f"{wrong} of {len(poses)}")
        row(peer.name, *cells, *lists)
    touching = {name: sum(map(bool, truth)) for name, truth in truths.items()}
    print("\nTouching, of these poses: "
          + ", ".join(f"`{name}` {count}" for name, count in touching.items()) + ".\n")


def quick(peers):
    print("## Quick\n")
    a = ta.Body.generate("sedan", 20_000).triangles
    b = ta.Body.generate("suv", 20_000).triangles
    random = np.random.default_rng(1)
    poses = shapes.poses(POSES, 0, 1)
    for pose in poses:
        turn = random.uniform(-np.pi, np.pi)
        c, s = np.cos(turn), np.sin(turn)
        pose[:3, :3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        pose[:3, 3] = random.uniform([-5, -3.5, -0.2], [5, 3.5, 0.2])
    made, answers = {}, {}
    builds = {}
    for peer in peers:
        made[peer], builds[peer] = spent(lambda: peer(a, b))
    times = {peer: [] for peer in peers}
    counts = dict.fromkeys(peers, POSES)
    for peer in peers:
        few = poses[:3]
        _, took = spent(lambda: made[peer].touches(few))
        counts[peer] = int(min(POSES, max(3, LIMIT_S / (took / len(few)))))
    for _ in range(ROUNDS):
        for peer in peers:
            own = poses[: counts[peer]]
            answers[peer], took = spent(lambda: made[peer].touches(own))
            times[peer].append(took / len(own))
    ours = answers[Ours]
    # Of each pose at which we say that they touch, one pair is proven; lists are compared below.
    base = statistics.median(times[Fcl]) if Fcl in times else None
    print(f"Two cars of 20,000 triangles, at {POSES:,} poses, {100 * ours.mean():.0f} % of which "
          f"touch. CPU time per pose, median of {ROUNDS} rounds, and how often python-fcl's time "
          "that is; slow libraries take the first poses alone. Poses at which the answer differs "
          "from ours; of ours, a pair of each of 200 poses that touch was proven in rational "
          "arithmetic.\n")
    row("library", "call", "poses", "build", "CPU time per pose", "× python-fcl", "differs")
    row("---", "---", "--:", "--:", "--:", "--:", "--:")
    proven(a, b, poses, ours)
    for peer in peers:
        median = statistics.median(times[peer])
        differs = int((answers[peer] != ours[: counts[peer]]).sum())
        ratio = f"{base / median:.3g}" if base else "–"
        row(peer.name, peer.says, f"{counts[peer]:,}", time_of(builds[peer]), time_of(median),
            ratio, differs if peer is not Ours else "–")
    gate = base / statistics.median(times[Ours]) if base else 0
    verdict = "held" if gate >= 10 else "MISSED"
    print(f"\nGate: `touches` at 10⁴ poses takes at most a tenth of python-fcl's CPU time in the "
          f"same run. It takes 1/{gate:.1f}: {verdict}.\n")
    return gate >= 10


def proven(a, b, poses, touching):
    there = Ours(a, b)
    for pose in poses[touching][:200]:
        i, j = there.pairs(pose)[0]
        moved = oracle.transformed(b[j : j + 1], pose)[0]
        assert oracle.intersect(a[i], moved), "a pair that does not intersect"


def listed(peers):
    print("## All pairs\n")
    a = ta.Body.generate("sedan", 20_000).triangles
    b = ta.Body.generate("suv", 20_000).triangles
    poses = [shapes.moved(x, 0.3, 0.05) for x in (3.6, 3.9, 4.2, 4.5)]
    print("The same cars at four poses: which triangles intersect? CPU time per pose, and pairs "
          "that differ from ours over all four.\n")
    row("library", "pairs", "CPU time per pose", "differ")
    row("---", "--:", "--:", "--:")
    expected = None
    for peer in peers:
        if peer is OneByOne or peer.pairs is None:
            continue
        there = peer(a, b)
        lists = [set(map(tuple, there.pairs(pose))) for pose in poses]
        times = [spent(lambda: [there.pairs(pose) for pose in poses])[1] for _ in range(ROUNDS)]
        expected = expected or lists
        differ = sum(len(own ^ ours) for own, ours in zip(lists, expected))
        row(peer.name, f"{sum(map(len, lists)):,}", time_of(statistics.median(times) / len(poses)),
            f"{differ:,}" if peer is not Ours else "–")
    print()


TWO = """
schema = "trolley.scenario/2"
name = "Two"
[parties]
ego = { generate = { shape = "sedan", triangles = 12000 } }
[parties.pole]
generate = { shape = "pole", triangles = 4000 }
place = { position_m = [12, -1.5, 0] }
[parties.pedestrian]
generate = { shape = "pedestrian", triangles = 8000 }
state = { position_m = [12, 0.4, 0], yaw_deg = 90, speed_m_s = 1 }
"""


def candidates(count):
    """A scene of 24,000 triangles with so many ways."""
    text = TWO
    for number in range(count):
        sideways = -1.4 + 2.4 * number / max(1, count - 1)
        text += (f'[[candidates]]\nname = "way {number}"\nstate = {{ position_m = [0, 0, 0], '
                 f"velocity_m_s = [9, {sideways!r}] }}\n")
    return text


def of_children(call):
    """CPU time of the processes that a call starts and waits for."""
    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    begun = used()
    answer = call()
    return answer, used() - begun


def answer_of(said):
    return json.loads(said)["answer"]


def ranking(folder):
    print("## Rankings\n")
    print("CPU time per scene: `rank_many` over ten speeds of a scene of 24,000 triangles, in a "
          "session that has its bodies; the same in a new session for each scene; and a process "
          "for each, `rank --json --in-process`. Medians of three. All three give equal "
          "answers.\n")
    row("candidates", "members", "`rank_many`", "new session", "process", "process ÷ `rank_many`")
    row("--:", "--:", "--:", "--:", "--:", "--:")
    gates = []
    for count in (2, 7):
        for members in (1, 32):
            texts = [candidates(count).replace("[9,", f"[{9 + 0.05 * turn!r},") for turn in range(10)]
            scenarios = [ta.Scenario.parse(text) for text in texts]
            session = ta.Session()
            limits = {"members": members}
            warm = session.rank_many(scenarios[:1], **limits)
            many, alone, process = [], [], []
            path = os.path.join(folder, "scene.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(texts[0])
            command = [TROLLEY, "rank", path, "--json", "--in-process", "--members", str(members)]
            for _ in range(ROUNDS):
                _, took = spent(lambda: session.rank_many(scenarios, **limits))
                many.append(took / len(scenarios))
                one, took = spent(lambda: ta.Session().rank(scenarios[0], **limits))
                alone.append(took)
                call = lambda: subprocess.run(command, capture_output=True, check=True).stdout  # noqa: E731
                said, took = of_children(call)
                process.append(took)
                assert answer_of(said) == one.answer == warm[0].answer, "answers differ"
            many, alone, process = map(statistics.median, (many, alone, process))
            row(count, members, time_of(many), time_of(alone), time_of(process),
                f"{process / many:.1f}")
            if members == 1:
                gates.append(process / many)
    verdict = "held" if min(gates) >= 10 else "MISSED"
    print(f"\nGate: with one member, at most a tenth of the process call. The least ratio is "
          f"{min(gates):.1f}: {verdict}.\n")
    return min(gates) >= 10


def assessments():
    """What an assessment of a searched scene takes, beside a ranking."""
    print("## Assessments\n")
    print("CPU time, for a scene as above, in a session that has its bodies: a search, of as many "
          "members as some policy may ask for (128 where 32 are asked for); an assessment under "
          "one of nine policies, from `assess_many`; the same without worlds; and a ranking under "
          "one of them, from `rank_under`. Medians of three. Assessments and rankings give equal "
          "bytes.\n")
    row("candidates", "members", "search", "assessment", "without worlds", "ranking",
        "ranking ÷ assessment", "nine rankings ÷ search and nine assessments")
    row("--:", "--:", "--:", "--:", "--:", "--:", "--:", "--:")
    names = ta.policy_names()
    for count in (2, 7):
        scenario = ta.Scenario.parse(candidates(count))
        for members in (1, 32):
            session = ta.Session()
            session.rank(scenario, members=1)
            once, each, bare, fresh = [], [], [], []
            for _ in range(ROUNDS):
                searched, took = spent(lambda: session.search(scenario, members=members))
                once.append(took)
                assessed, took = spent(lambda: ta.assess_many([searched], policies=names))
                each.append(took / len(names))
                _, took = spent(lambda: ta.assess_many([searched], policies=names, worlds=0))
                bare.append(took / len(names))
                ranked, took = spent(lambda: session.rank_under(scenario, names, members=members))
                fresh.append(took / len(names))
                assert [one.json for one in assessed] == [one.json for one in ranked], "they differ"
            once, each, bare, fresh = map(statistics.median, (once, each, bare, fresh))
            both = len(names) * fresh / (once + len(names) * each)
            row(count, members, *map(time_of, (once, each, bare, fresh)), f"{fresh / each:.1f}",
                f"{both:.1f}")
    print()


def threads():
    """What two threads cost and gain."""
    os.sched_setaffinity(0, ALL)
    a, b = ta.Body.generate("sedan", 20_000), ta.Body.generate("suv", 20_000)
    poses = shapes.poses(POSES, 2.5, 3)
    quicker, dearer = [], []
    for _ in range(THREAD_ROUNDS):
        clock, processor = [], []
        for number in (1, 2):
            begun = time.perf_counter()
            _, took = spent(lambda: ta.touches(a, b, poses, threads=number))
            clock.append(time.perf_counter() - begun)
            processor.append(took)
        quicker.append(clock[0] / clock[1])
        dearer.append(processor[1] / processor[0])
    print("## Threads\n")
    print(f"`touches` on two threads takes {statistics.median(dearer):.2f} times the CPU time of "
          f"one, and is {statistics.median(quicker):.2f} times as quick by the clock "
          f"({min(quicker):.2f} to {max(quicker):.2f} over {THREAD_ROUNDS} rounds), on {len(ALL)} cores "
          f"whose load was {os.getloadavg()[0]:.1f} before.")


ALL = set(range(os.cpu_count() or 1))


def main():
    import tempfile

    peers, missing = available()
    print("Versions: " + ", ".join(f"{peer.package} {version(peer)}" for peer in peers
                                   if peer is not OneByOne) + f", numpy {np.__version__}.")
    if missing:
        print("\nLeft out: " + "; ".join(missing) + ".")
    print()
    right(peers)
    held = quick(peers)
    listed(peers)
    with tempfile.TemporaryDirectory() as folder:
        held &= ranking(folder)
    assessments()
    threads()
    sys.exit(not held)


if __name__ == "__main__":
    main()

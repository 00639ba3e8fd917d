"""Whether every engine gives the same rows of a study, whatever is killed; what the engine costs.

Two Ray nodes run here, in a network namespace that has nothing but `lo`; `cargo x engines` starts
it there, and writes what it prints to tools/results/study/engines.md.

    engines.py FOLDER --scenes N --seeds N
"""

import argparse
import json
import os
import random
import secrets
import shutil
import signal
import subprocess
import sys
import threading
import time
from importlib.metadata import version
from pathlib import Path

import duckdb
import polars
from trolley_av import study

TICKS = os.sysconf("SC_CLK_TCK")
PORT = 6379
TABLES = ("answers", "candidates", "persons")
KEYS = {"answers": ["row"], "candidates": ["row", "place"],
        "persons": ["row", "place", "party", "seat"]}

SCENE = """\
schema = "trolley.scenario/2"
name = "two ways"
members = 1
horizon_s = 3
[parties.ego]
generate = { shape = "sedan", triangles = 600 }
[parties.pole]
generate = { shape = "pole", triangles = 600 }
place = { position_m = [22, 1.5, 0] }
[parties.cyclist]
generate = { shape = "cyclist", triangles = 600 }
state = { position_m = [24, -5, 0], yaw_deg = 90, speed_m_s = 4 }
[[candidates]]
name = "straight on"
state = { position_m = [0, 0, 0], speed_m_s = 11 }
[[candidates]]
name = "left"
state = { position_m = [0, 0, 0], velocity_m_s = [11, 0.8] }
"""


def spec(scenes):
    speeds = max(scenes // 100, 2)
    return f"""\
schema = "trolley.study/1"
name = "engines"
members = 1
policies = ["default"]
scenes_per_shard = {max(scenes // 40, 1)}
[[scenarios]]
files = ["scene.toml"]
[sweep.speed]
from = 0.5
to = 1.5
count = {speeds}
[sweep.offset_m]
from = -1.0
to = 1.0
count = {scenes // speeds}
"""


# --- processes -----------------------------------------------------------------------------------

def stat(pid):
    """Parent and state of a process; None if there is none."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return None
    fields = text.rsplit(")", 1)[1].split()
    return int(fields[1]), fields[0]


def tree(root):
    """The processes below one, and it."""
    parents = {}
    for name in os.listdir("/proc"):
        if name.isdigit() and (found := stat(name)) and found[1] != "Z":
            parents.setdefault(found[0], []).append(int(name))
    known, todo = [], [root]
    while todo:
        pid = todo.pop()
        known.append(pid)
        todo += parents.get(pid, [])
    return known


def kill_tree(process):
    """Stops all processes of a tree, then kills them; returns their ids."""
    for number in (signal.SIGSTOP, signal.SIGKILL):
        # What was forked meanwhile is found the second time.
        pids = tree(process.pid)
        for pid in pids:
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass
        if number == signal.SIGSTOP:
            stopped = pids
    process.wait()
    pids = set(stopped) | set(pids)
    # Whoever inherits them collects them a little later.
    wait_until(lambda: not any(lives(pid) for pid in pids), "killed processes end", 20)
    return pids


def lives(pid):
    found = stat(pid)
    return found is not None and found[1] != "Z"


class Used:
    """CPU time that trees of processes take, sampled, so that ended processes count too."""

    def __init__(self, roots):
        self.roots, self.first, self.last = roots, {}, {}
        self.is_over = threading.Event()
        self.thread = threading.Thread(target=self._sample)

    def __enter__(self):
        self._look()
        self.first = dict(self.last)
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.is_over.set()
        self.thread.join()
        self._look()

    def _look(self):
        for root in self.roots:
            for pid in tree(root):
                # Its own alone: children are looked at themselves.
                if (seconds := own(pid)) is not None:
                    self.last[pid] = seconds

    def _sample(self):
        while not self.is_over.wait(0.25):
            self._look()

    def seconds(self):
        return sum(self.last.values()) - sum(self.first.values())


def own(pid):
    """CPU time of a process (s) without its children; None if there is none."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return None
    fields = text.rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


# --- Ray -----------------------------------------------------------------------------------------

class Cluster:
    """Nodes of a Ray cluster on loopback, each a tree of processes with one CPU."""

    def __init__(self, folder):
        self.folder = folder
        self.ray = str(Path(sys.executable).parent / "ray")
        self.environment = {
            **os.environ, "RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32),
            "RAY_USAGE_STATS_ENABLED": "0", "PYTHONDONTWRITEBYTECODE": "1",
            # Ray has workers step back by 15; times by the clock compare what is equally nice.
            "RAY_worker_niceness": "0",
        }
        self.log = open(folder / "ray.log", "wb")
        self.nodes = {}

    def start(self, name):
        common = ["--num-cpus=1", "--object-store-memory=100000000", "--block",
                  "--disable-usage-stats", "--include-log-monitor=false"]
        if name == "head":
            where = ["--head", f"--port={PORT}", "--node-ip-address=127.0.0.1",
                     "--include-dashboard=false", "--no-monitor", f"--temp-dir={self.folder / 'r'}"]
        else:
            where = [f"--address=127.0.0.1:{PORT}", "--node-ip-address=127.0.0.2"]
        self.nodes[name] = subprocess.Popen(
            [self.ray, "start", *where, *common], env=self.environment, stdin=subprocess.DEVNULL,
            stdout=self.log, stderr=self.log, start_new_session=True)

    def wait_for(self, cpus):
        """Waits until tasks have so many CPUs."""
        script = ("import ray, sys, time\n"
                  f"ray.init('127.0.0.1:{PORT}', log_to_driver=False, logging_level='error')\n"
                  f"while ray.cluster_resources().get('CPU', 0) != {cpus}: time.sleep(0.2)\n")
        for _ in range(30):
            done = subprocess.run([sys.executable, "-c", script], env=self.environment,
                                  stdout=self.log, stderr=self.log, timeout=120, check=False)
            if done.returncode == 0:
                return
            time.sleep(1)
        raise SystemExit("the cluster does not come up: see ray.log")

    def driver(self, study):
        command = [sys.executable, "-m", "trolley_av.study", str(study), "--ray",
                   f"127.0.0.1:{PORT}"]
        return subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL,
                                stdout=self.log, stderr=self.log, start_new_session=True)

    def stop(self):
        for node in self.nodes.values():
            kill_tree(node)


# --- studies -------------------------------------------------------------------------------------

class Studies:
    def __init__(self, folder, scenes):
        self.folder = folder
        (folder / "spec.toml").write_text(spec(scenes))
        (folder / "scene.toml").write_text(SCENE)
        self.planned = folder / "planned"
        study.plan(folder / "spec.toml", self.planned)

    def fresh(self, name):
        copy = self.folder / name
        shutil.copytree(self.planned, copy)
        return copy


def finished(study):
    return len(os.listdir(study / "shards"))


def in_hand(study, pids):
    """How many shards one of these processes has in hand."""
    held = [path.stem for path in (study / "attempts").glob("*.hand")]
    begun = [(study / "attempts" / f"{shard}.log").read_text().splitlines() for shard in held]
    last = [[line for line in lines if line.startswith("begin ")][-1] for lines in begun]
    return sum(int(line.split()[-1]) in pids for line in last)


def wait_until(holds, what, seconds=900):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise SystemExit(f"{what}: not within {seconds} s")
        time.sleep(0.02)


def frames(study):
    read = {}
    for table in TABLES:
        frame = polars.read_parquet(study / "shards" / "*" / f"{table}.parquet")
        read[table] = frame.sort(KEYS[table], nulls_last=True)
    return read


class Verdict:
    """What did not hold."""

    def __init__(self):
        self.faults = []

    def holds(self, is_held, what):
        if not is_held:
            self.faults.append(what)
        return "yes" if is_held else "**NO**"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scenes", type=int, default=20_000)
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    folder = given.folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    studies, verdict = Studies(folder, given.scenes), Verdict()
    load = os.getloadavg()[0]

    # One process, and its CPU time.
    one = studies.fresh("one")
    before = time.monotonic()
    child = subprocess.Popen([sys.executable, "-m", "trolley_av.study", str(one)],
                             stderr=subprocess.DEVNULL)
    _, code, usage = os.wait4(child.pid, 0)
    assert code == 0, code
    one_s, one_cpu_s = time.monotonic() - before, usage.ru_utime + usage.ru_stime
    expected = study.status(one)
    right = frames(one)
    print(f"one process: {one_cpu_s:.1f} s", file=sys.stderr, flush=True)

    rows = []

    def same(name, path):
        now = study.status(path)
        equal = now["rows_hash"] == expected["rows_hash"] is not None
        found = frames(path)
        equal &= all(found[table].equals(right[table]) for table in TABLES)
        rows.append([name, f"{now['finished']} of {now['shards']}", str(now["attempts"]),
                     verdict.holds(equal, f"{name}: other rows")])
        return now

    loop = studies.fresh("loop")
    for shard in range(expected["shards"]):
        subprocess.run([sys.executable, "-m", "trolley_av.study", str(loop), "--shard", str(shard)],
                       check=True, stderr=subprocess.DEVNULL)
    same("`python -m trolley_av.study DIR --shard K`, one after the other", loop)
    print("loop: done", file=sys.stderr, flush=True)

    cluster = Cluster(folder)
    kills = []
    try:
        cluster.start("head")
        cluster.wait_for(1)
        costs = {1: cost(cluster, studies, 1)}
        same("Ray, one node", folder / "nodes-1")
        cluster.start("second")
        cluster.wait_for(2)
        costs[2] = cost(cluster, studies, 2)
        same("Ray, two nodes", folder / "nodes-2")
        print(f"Ray: {costs}", file=sys.stderr, flush=True)
        for seed in range(1, given.seeds + 1):
            kills.append(killed(cluster, studies, seed, verdict))
            now = same(f"Ray, seed {seed}: a node killed, then the driver", folder / f"seed-{seed}")
            more = now["attempts"] - now["shards"]
            kills[-1] += [str(more), verdict.holds(more <= kills[-1][-1], f"seed {seed}: attempts")]
            print(f"seed {seed}: {kills[-1]}", file=sys.stderr, flush=True)
    finally:
        cluster.stop()

    print(page(given, expected, rows, kills, costs, (one_cpu_s, one_s), load, folder, verdict))
    for fault in verdict.faults:
        print(f"does not hold: {fault}", file=sys.stderr)
    return 1 if verdict.faults else 0


DRIVER = """\
import json, sys
from trolley_av import study
cpu = []
failed = study.run_on_ray(sys.argv[1], sys.argv[2], told=lambda shard: cpu.append(shard["cpu_s"]))
print(json.dumps({"cpu_s": sum(cpu), "failed": failed}))
"""


def cost(cluster, studies, nodes):
    """CPU time of shards and of all else, and time by the clock, on so many nodes."""
    path = studies.fresh(f"nodes-{nodes}")
    before = time.monotonic()
    driver = subprocess.Popen(
        [sys.executable, "-c", DRIVER, str(path), f"127.0.0.1:{PORT}"], env=cluster.environment,
        stdout=subprocess.PIPE, stderr=cluster.log, start_new_session=True)
    with Used([driver.pid, *[node.pid for node in cluster.nodes.values()]]) as used:
        said, _ = driver.communicate()
    told = json.loads(said)
    assert not told["failed"], told
    return {"shards_s": told["cpu_s"], "all_s": used.seconds(),
            "clock_s": time.monotonic() - before}


def killed(cluster, studies, seed, verdict):
    """Kills a whole node, then the driver, at moments of a seed, and begins again."""
    draw = random.Random(seed)
    path = studies.fresh(f"seed-{seed}")
    shards = 40
    first, second = draw.randrange(2, 16), draw.randrange(20, 36)
    delays = [draw.random(), draw.random()]
    driver = cluster.driver(path)
    wait_until(lambda: finished(path) >= first, f"seed {seed}: {first} shards")
    time.sleep(delays[0])
    at_node = finished(path)
    pids = kill_tree(cluster.nodes["second"])
    of_node = in_hand(path, pids)
    wait_until(lambda: finished(path) >= second, f"seed {seed}: {second} shards")
    time.sleep(delays[1])
    at_driver = finished(path)
    # Its workers are Ray's, which ends them. What the dead node had is noted there still.
    living = {int(name) for name in os.listdir("/proc") if name.isdigit() and lives(name)}
    kill_tree(driver)
    of_driver = in_hand(path, living)
    cluster.start("second")
    cluster.wait_for(2)
    driver = cluster.driver(path)
    code = driver.wait()
    verdict.holds(code == 0, f"seed {seed}: the second driver ended with {code}")
    flight = of_node + of_driver
    return [seed, f"{at_node} of {shards}", of_node, f"{at_driver} of {shards}", of_driver, flight]


def page(given, expected, rows, kills, costs, one, load, folder, verdict):
    (one_cpu_s, one_s) = one
    table = lambda head, lines: "\n".join(
        ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
        + ["| " + " | ".join(map(str, line)) + " |" for line in lines])
    of = {nodes: cost["all_s"] / cost["shards_s"] - 1 for nodes, cost in costs.items()}
    gate = verdict.holds(of[2] <= 0.05, f"overhead {of[2]:.3f}")
    parquet = str(folder / "one" / "shards" / "*" / "answers.parquet")
    [count, scenes, refused] = duckdb.sql(
        f"select count(*), count(distinct scene), count(refusal) from '{parquet}'").fetchall()[0]
    [winners] = duckdb.sql(
        "select string_agg(policy || ': ' || winner || ' ' || n, ', ' order by policy, winner) from "
        f"(select policy, winner, count(*) n from '{parquet}' where winner is not null group by all)"
    ).fetchall()[0]
    polars_count = polars.scan_parquet(parquet).select(polars.len()).collect().item()
    read = verdict.holds(count == polars_count == expected["rows"][0], "tables")
    lines = []
    for seed, at_node, of_node, at_driver, of_driver, flight, more, held in kills:
        lines.append([seed, at_node, of_node, at_driver, of_driver, more, flight, held])
    return f"""\
{expected['scenes']:,} scenes of three small bodies and two candidates (`members = 1`), in \
{expected['shards']} shards. Two Ray nodes with one CPU each, in a network namespace with `lo` alone. \
Load of the machine before: {load:.1f}. Ray {version('ray')}, DuckDB {duckdb.__version__}, Polars \
{polars.__version__}.

## The same rows

Against one process: the hash of all rows, and each row of the three tables in Polars.

{table(["engine", "shards finished", "attempts", "same rows"], rows)}

## Killed

A whole node, all its processes, at a random moment; then the driver; then a new node and a new driver. \
A shard that nobody had in hand is begun once.

{table(["seed", "node killed at", "its shards in hand", "driver killed at", "shards in hand",
        "attempts − shards", "at most", "held"], lines)}

## What the engine costs

CPU time in shards, and of all processes of the cluster and the driver from its start to its end.

{table(["nodes", "shards", "all", "overhead", "time by the clock"],
       [[nodes, f"{cost['shards_s']:.1f} s", f"{cost['all_s']:.1f} s", f"{of[nodes]:.1%}",
         f"{cost['clock_s']:.1f} s"] for nodes, cost in costs.items()])}

One process without an engine: {one_cpu_s:.1f} s of CPU time in {one_s:.1f} s. Two nodes are \
{costs[1]['clock_s'] / costs[2]['clock_s']:.2f} times as quick as one.

Gate: with two nodes at most 5 % of the CPU time of shards: {gate}.

## Who reads the tables

DuckDB counts {count:,} answers to {scenes:,} scenes, {refused:,} of them refusals; Polars as many: {read}. \
Who wins, by DuckDB: {winners}.
"""


if __name__ == "__main__":
    sys.exit(main())

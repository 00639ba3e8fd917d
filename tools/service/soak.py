#!/usr/bin/env python3
"""Runs a service for a long time under every kind of fault that a machine has, and records what it holds.

    cargo build --release -p trolley-cli -p trolley-client-c
    python3 tools/service/soak.py --minutes 60 --out tools/results/service

Two clients ask without pause, one of them with deadlines that are too short for all the work; a third
sends requests with random bytes through the C library, and every eighth time a proper one. Every ten
seconds 64 clients come at once; a quarter of them is killed within 40 ms. Each second a worker is
killed, sometimes its successor, too, within its first 10 ms; every seventh second one is stopped, and
every other time goes on after up to half a second. Answers are compared by `trolley query --repeat`
itself with what its own process computes, those of the third client with the first of their kind.
SIGTERM ends the service, and SIGINT this program, early. The page is written every five minutes.
Needs nothing but Python's standard library.
"""

import argparse
import ctypes
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
INSTANCE = f"soak{os.getpid() % 10000}"
CROWD = 64
# Complete or certified, degraded, refused, busy or not running: what a client may see.
CODES = {0, 3, 4, 75}
# What must be flat, with the name of its line in the picture.
HELD = {
    "resident_mb": "resident memory of the service (MB)",
    "workers_mb": "resident memory of its workers (MB)",
    "descriptors": "open descriptors of the service",
    "threads": "threads of the service",
    "names": "shared files",
}


def children(pid):
    """Workers of the service, and what cleans up for it, by process id."""
    try:
        text = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text()
    except OSError:
        return []
    return [int(child) for child in text.split()]


def send(pid, number):
    """A signal to a process that may just have ended."""
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


def held(pid):
    """Resident memory (MB), open descriptors and threads of one process."""
    pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * 4096 / 1e6, len(os.listdir(f"/proc/{pid}/fd")), len(os.listdir(f"/proc/{pid}/task"))


def names():
    """Files and folders that the service and its runs share."""
    user = os.environ.get("XDG_RUNTIME_DIR")
    folder = pathlib.Path(user, "trolley") if user else pathlib.Path(f"/dev/shm/trolley-{os.getuid()}")
    mine = [path for path in folder.glob("*") if INSTANCE in path.name]
    # Unlike rglob, os.walk passes by what goes while it looks.
    return sum(1 + sum(len(folders) + len(files) for _, folders, files in os.walk(path)) for path in mine)


def top(program, deployment):
    """What the service says of itself."""
    args = [program, "top", deployment, "--instance", INSTANCE, "--times", "1", "--json"]
    done = subprocess.run(args, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else None


def hostile(instance, seed):
    """Sends spoilt requests, 200 and a proper one between eight of them, and prints what came."""
    sys.path.insert(0, str(ROOT / "tools/clients"))
    import planner

    lib, dice = planner.library(), random.Random(seed)
    why = ctypes.create_string_buffer(512)
    client = lib.trolley_connect(None, instance.encode(), 100_000, why, len(why))
    if not client:
        print(json.dumps({"not_connected": 1}))
        return
    counts, wrong, first = {}, 0, None
    for number in range(200):
        ask = planner.what_is_left()
        # Ids of the soak's deployment: 2 a pole, 4 a wall.
        ask.parties[1].model, ask.parties[2].model = 2, 4
        if number % 8:
            data = bytearray(bytes(ask))
            for _ in range(dice.choice([1, 4, 64, 1024])):
                # The head has what counts the rest.
                place = dice.randrange(dice.choice([128, 17_536, 17_536 + 80 * ask.state_count]))
                data[place] = dice.choice([0, 1, 0x7F, 0x80, 0xFF, dice.randrange(256)])
            ask = planner.Ask.from_buffer(data)
        answer = planner.Answer()
        lib.trolley_ask(client, ask, 500_000_000, answer)
        kind = ("spoilt " if number % 8 else "proper ") + planner.VERDICTS[answer.verdict]
        counts[kind] = counts.get(kind, 0) + 1
        if number % 8 == 0 and answer.verdict == 1:
            ranking = [(place.candidate, tuple(place.work), tuple(place.range))
                       for place in answer.places[:answer.place_count]]
            first = first or ranking
            wrong += ranking != first
    lib.trolley_disconnect(client)
    print(json.dumps({"counts": counts, "wrong": wrong}))


def polyline(samples, key, top_value, left, width, base, height):
    end = samples[-1]["s"] or 1
    at = lambda s: f"{left + width * s['s'] / end:.1f},{base - height * s[key] / top_value:.1f}"
    return " ".join(at(sample) for sample in samples)


def draw(samples, path):
    """One line for all that must be flat, over time, each from zero."""
    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="720" height="595" font-size="12" '
           'font-family="sans-serif"><rect width="720" height="595" fill="white"/>']
    for number, (key, title) in enumerate(HELD.items()):
        base, most = 110 + 115 * number, max(sample[key] for sample in samples) * 1.15 or 1
        out.append(f'<text x="60" y="{base - 88}">{title}: at most {max(s[key] for s in samples):.0f}'
                   f', at the end {samples[-1][key]:.0f}</text>')
        out.append(f'<path d="M60 {base}H700M60 {base}v-80" stroke="#888" fill="none"/>')
        points = polyline(samples, key, most, 60, 640, base, 80)
        out.append(f'<polyline points="{points}" fill="none" stroke="#1f5fa8" stroke-width="1.5"/>')
    out.append(f'<text x="60" y="588">0</text><text x="700" y="588" text-anchor="end">'
               f'{samples[-1]["s"] / 60:.0f} min, a worker killed each second</text></svg>')
    path.write_text("\n".join(out))


def flat(samples, key):
    """Medians and most of the second and the last tenth: the first is of warming up."""
    tenth = max(len(samples) // 10, 1)
    parts = {"second_tenth": samples[tenth:2 * tenth] or samples, "last_tenth": samples[-tenth:]}
    values = {name: sorted(s[key] for s in part) for name, part in parts.items()}
    return {name: {"median": v[len(v) // 2], "most": v[-1]} for name, v in values.items()}


class Soak:
    """What runs, and what has been counted."""

    def __init__(self, options):
        self.options, self.dice = options, random.Random(options.seed)
        # Four workers, and as many successors as it takes.
        text = (ROOT / "config/deployments/four.toml").read_text()
        text = text.replace("workers = 2", "workers = 4")
        restarts = "[restarts]\ncore_in_10_s = 1000\nall_in_60_s = 10000\n\n[[models]]"
        self.deployment = str(options.out / "soak.toml")
        pathlib.Path(self.deployment).write_text(text.replace("[[models]]", restarts, 1))
        self.log = open(options.out / "soak.log", "w")
        scenario = str(ROOT / "config/scenarios/four.toml")
        self.query = [options.program, "query", self.deployment, scenario,
                      "--instance", INSTANCE, "--json"]
        library = pathlib.Path(options.program).resolve().parent
        self.hostile = [sys.executable, __file__, "--hostile", INSTANCE, "--seed"]
        self.path = {**os.environ, "LD_LIBRARY_PATH": str(library)}
        self.steady = {
            "patient": lambda: self.query + ["--repeat", "1000", "--deadline-ms", "1000"],
            "hasty": lambda: self.query + ["--repeat", "1000", "--deadline-ms", "4"],
            "spoilt": lambda: self.hostile + [str(self.dice.randrange(1 << 30))],
        }
        self.running, self.crowd, self.samples, self.seen = {}, [], [], None
        self.counts = {"workers_killed": 0, "successors_killed": 0, "workers_stopped": 0,
                       "clients": 0, "clients_killed": 0, "wrong": 0}
        self.answers, self.spoilt, self.codes, self.failed = [0] * 5, {}, {}, []
        self.serve = [options.program, "serve", self.deployment, "--instance", INSTANCE]
        self.service = subprocess.Popen(self.serve, stderr=self.log, stdout=self.log)
        self.begun = time.monotonic()

    def start_steady(self):
        """Each of the steady clients runs; what ended is counted."""
        for name, command in self.steady.items():
            process = self.running.get(name)
            if process is not None:
                if process.poll() is None:
                    continue
                self.count(name, process)
            self.running[name] = subprocess.Popen(
                command(), stdout=subprocess.PIPE, text=True, stderr=self.log, env=self.path)

    def count(self, name, process):
        text = process.stdout.read()
        document = json.loads(text) if text.strip() else None
        if process.returncode not in CODES:
            self.failed.append(f"{name}: exit code {process.returncode}")
        if document is None:
            self.codes[process.returncode] = self.codes.get(process.returncode, 0) + 1
        elif name == "spoilt":
            for kind, count in document.get("counts", document).items():
                self.spoilt[kind] = self.spoilt.get(kind, 0) + count
            self.counts["wrong"] += document.get("wrong", 0)
        elif "answers" in document:
            self.answers = [a + b for a, b in zip(self.answers, document["answers"])]
            self.counts["wrong"] += document["wrong"]

    def start_crowd(self):
        """All at once; a quarter will be killed, at a moment of its own."""
        doomed = []
        for _ in range(CROWD):
            process = subprocess.Popen(self.query, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            now = time.monotonic()
            due = now + self.dice.random() * 0.04 if self.dice.random() < 0.25 else None
            self.crowd.append((process, due, now))
            doomed += [] if due is None else [(due, process)]
            doomed = self.kill_due(doomed)
        while doomed:
            time.sleep(0.001)
            doomed = self.kill_due(doomed)
        self.counts["clients"] += CROWD

    def kill_due(self, doomed):
        """Kills clients whose moment has come; returns the others."""
        now = time.monotonic()
        for _, process in (client for client in doomed if client[0] <= now):
            self.counts["clients_killed"] += process.poll() is None
            process.kill()
        return [client for client in doomed if client[0] > now]

    def reap_crowd(self):
        left = []
        for process, due, begun in self.crowd:
            code = process.poll()
            if code is None:
                left.append((process, due, begun))
                # A second to be answered, and the rest for two cores to start sixty processes.
                if due is None and time.monotonic() - begun > 60:
                    self.failed.append(f"client {process.pid} hangs")
                    process.kill()
            elif due is None:
                self.codes[code] = self.codes.get(code, 0) + 1
                if code not in CODES:
                    self.failed.append(f"crowd: exit code {code}")
        self.crowd = left

    def strike(self, second):
        """Kills a worker, sometimes its successor; stops one, and lets every other go on."""
        workers = children(self.service.pid)
        if not workers:
            return
        send(self.dice.choice(workers), signal.SIGKILL)
        self.counts["workers_killed"] += 1
        if self.dice.random() < 0.3:
            time.sleep(0.005)
            for successor in set(children(self.service.pid)) - set(workers):
                time.sleep(self.dice.random() * 0.01)
                send(successor, signal.SIGKILL)
                self.counts["successors_killed"] += 1
        if second % 7 == 0:
            worker = self.dice.choice(workers)
            send(worker, signal.SIGSTOP)
            self.counts["workers_stopped"] += 1
            if second % 14 == 0:
                time.sleep(self.dice.random() * 0.5)
                if worker in children(self.service.pid):
                    send(worker, signal.SIGCONT)

    def sample(self):
        memory, descriptors, threads = held(self.service.pid)
        of_workers = 0
        for worker in children(self.service.pid):
            try:
                of_workers += held(worker)[0]
            except OSError:
                pass  # It has just ended.
        self.samples.append({"s": time.monotonic() - self.begun, "resident_mb": memory,
                             "workers_mb": of_workers, "descriptors": descriptors,
                             "threads": threads, "names": names()})

    def run(self):
        while self.seen is None:
            if self.service.poll() is not None:
                sys.exit("the service did not start: see soak.log")
            time.sleep(0.2)
            self.seen = top(self.options.program, self.deployment)
        end, written, second = time.monotonic() + 60 * self.options.minutes, 0, 0
        while time.monotonic() < end and self.service.poll() is None:
            second += 1
            turn = time.monotonic()
            self.start_steady()
            if second % 10 == 1:
                self.start_crowd()
            self.strike(second)
            # `top` waits for a message that comes once a second, but not where a crowd has all places.
            self.seen = top(self.options.program, self.deployment) or self.seen
            time.sleep(max(0.0, turn + 1.0 - time.monotonic()))
            self.reap_crowd()
            if self.service.poll() is not None:
                break
            self.sample()
            if time.monotonic() - self.begun > written + 300:
                written = time.monotonic() - self.begun
                self.write({"running": True})

    def end(self):
        """Ends all; the service by SIGTERM, while its clients still ask."""
        if self.service.poll() is not None:
            self.failed.append(f"the service ended by itself: {self.service.returncode}")
        begun = time.monotonic()
        self.service.send_signal(signal.SIGTERM)
        try:
            code = self.service.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.service.kill()
            code = self.service.wait()
        took = time.monotonic() - begun
        for process in list(self.running.values()) + [client[0] for client in self.crowd]:
            process.kill()
            process.wait()
        # What killed clients left is for the next service of this name to remove.
        left = names()
        again = subprocess.Popen(self.serve, stderr=self.log, stdout=self.log)
        while again.poll() is None and top(self.options.program, self.deployment) is None:
            time.sleep(0.2)
        again.send_signal(signal.SIGTERM)
        again.wait()
        return {"exit_code": code, "sigterm_s": round(took, 3), "names_of_killed_clients": left,
                "names_left": names()}

    def write(self, end):
        samples = self.samples
        kinds = ["complete", "certified", "degraded", "refused", "busy"]
        summary = {
            "minutes": samples[-1]["s"] / 60,
            **self.counts,
            "failed": self.failed,
            "answers": dict(zip(kinds, self.answers)),
            "spoilt_requests": dict(sorted(self.spoilt.items())),
            "single_queries_by_exit_code": {str(k): v for k, v in sorted(self.codes.items())},
            "service": self.seen,
            **{key: flat(samples, key) for key in HELD},
            **end,
        }
        draw(samples, self.options.out / "soak.svg")
        (self.options.out / "soak.json").write_text(json.dumps(summary, indent=2) + "\n")
        (self.options.out / "soak.md").write_text(page(summary))
        return summary


def page(summary):
    """The page of a run, from its figures."""
    lists = lambda counts: ", ".join(f"{count:,} {kind}" for kind, count in counts.items())
    rows = [
        ["", "second tenth, median", "most", "last tenth, median", "most"],
        ["---", "--:", "--:", "--:", "--:"],
        *[[title, *(f"{summary[key][part][of]:.1f}"
                    for part in ("second_tenth", "last_tenth") for of in ("median", "most"))]
          for key, title in HELD.items()],
    ]
    state = "It was still running when this was written." if summary.get("running") else (
        f"SIGTERM, while clients asked: ended after {summary['sigterm_s']:.2f} s with exit code "
        f"{summary['exit_code']}; {summary['names_left']} names left after the next start.")
    return "\n".join([
        "# A service under every kind of fault", "",
        "```sh", "python3 tools/service/soak.py --minutes 60 --out tools/results/service", "```", "",
        f"{summary['minutes']:.0f} minutes on {os.cpu_count()} cores, four workers. "
        f"{summary['workers_killed']:,} workers and {summary['successors_killed']:,} successors killed, "
        f"{summary['workers_stopped']:,} stopped; {summary['clients']:,} clients in crowds of {CROWD}, "
        f"{summary['clients_killed']:,} of them killed within 40 ms.", "",
        f"**Wrong answers {summary['wrong']}, hangs and unexpected ends {len(summary['failed'])}.** {state}", "",
        f"- Steady clients, compared: {lists(summary['answers'])}.",
        f"- Requests with random bytes, and proper ones between them: {lists(summary['spoilt_requests'])}.",
        f"- Clients of the crowd, by exit code: {lists(summary['single_queries_by_exit_code'])} "
        "(0 complete, 3 degraded, 4 refused, 75 busy).", "",
        *["| " + " | ".join(row) + " |" for row in rows], "", "![over time](soak.svg)", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "target/soak")
    parser.add_argument("--program", default=str(ROOT / "target/release/trolley"))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hostile", metavar="INSTANCE", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.hostile:
        hostile(options.hostile, options.seed)
        return
    options.out.mkdir(parents=True, exist_ok=True)
    soak = Soak(options)
    try:
        soak.run()
    except KeyboardInterrupt:
        pass
    finally:
        end = soak.end()
    summary = soak.write(end)
    print(json.dumps(summary, indent=2))
    good = not soak.failed and summary["wrong"] == 0 and end["exit_code"] == 0 and end["sigterm_s"] < 2
    good = good and end["names_left"] == 0
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()

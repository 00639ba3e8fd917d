#!/usr/bin/env python3
"""Runs a service for a long time under mixed load while its workers are killed, and draws what it holds.

    cargo build --release
    python3 tools/service/soak.py --minutes 30 --out tools/results/service

Two clients ask without pause, one of them with deadlines that are too short for all the work; a third
connects, asks once and goes. Each second a worker is killed. Answers are compared by `trolley query
--repeat` itself with what its own process computes. Needs nothing but Python's standard library.
"""

import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def children(pid):
    """Workers of the service, by process id."""
    text = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in text.split()]


def held(pid):
    """Resident memory (MB) and open descriptors of one process."""
    pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * 4096 / 1e6, len(os.listdir(f"/proc/{pid}/fd"))


def names():
    """Files and folders that the service and its runs share."""
    user = os.environ.get("XDG_RUNTIME_DIR")
    folder = pathlib.Path(user, "trolley") if user else pathlib.Path(f"/dev/shm/trolley-{os.getuid()}")
    mine = [path for path in folder.glob("*") if INSTANCE in path.name]
    return sum(1 + sum(1 for _ in path.rglob("*")) for path in mine)


def top(program, deployment):
    """What the service says of itself."""
    args = [program, "top", deployment, "--instance", INSTANCE, "--times", "1", "--json"]
    done = subprocess.run(args, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else None


def polyline(samples, key, top_value, left, width, base, height):
    end = samples[-1]["s"] or 1
    at = lambda s: f"{left + width * s['s'] / end:.1f},{base - height * s[key] / top_value:.1f}"
    return " ".join(at(sample) for sample in samples)


def draw(samples, path):
    """Four lines over time, each from zero."""
    rows = [
        ("resident_mb", "resident memory of the service (MB)"),
        ("workers_mb", "resident memory of its workers (MB)"),
        ("descriptors", "open descriptors of the service"),
        ("names", "shared files"),
    ]
    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="720" height="480" font-size="12" '
           'font-family="sans-serif"><rect width="720" height="480" fill="white"/>']
    for number, (key, title) in enumerate(rows):
        base, most = 110 + 115 * number, max(sample[key] for sample in samples) * 1.15 or 1
        out.append(f'<text x="60" y="{base - 88}">{title}: at most {max(s[key] for s in samples):.0f}'
                   f', at the end {samples[-1][key]:.0f}</text>')
        out.append(f'<path d="M60 {base}H700M60 {base}v-80" stroke="#888" fill="none"/>')
        points = polyline(samples, key, most, 60, 640, base, 80)
        out.append(f'<polyline points="{points}" fill="none" stroke="#1f5fa8" stroke-width="1.5"/>')
    out.append(f'<text x="60" y="475">0</text><text x="700" y="475" text-anchor="end">'
               f'{samples[-1]["s"] / 60:.0f} min, a worker killed each second</text></svg>')
    path.write_text("\n".join(out))


def flat(samples, key):
    """Medians and most of the second and the last tenth: the first is of warming up."""
    tenth = max(len(samples) // 10, 1)
    parts = {"second_tenth": samples[tenth:2 * tenth], "last_tenth": samples[-tenth:]}
    values = {name: sorted(s[key] for s in part) or [0] for name, part in parts.items()}
    return {name: {"median": v[len(v) // 2], "most": v[-1]} for name, v in values.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "target/soak")
    parser.add_argument("--program", default=str(ROOT / "target/release/trolley"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    # Four workers, and as many successors as it takes.
    text = (ROOT / "config/deployments/four.toml").read_text().replace("workers = 2", "workers = 4")
    deployment = str(options.out / "soak.toml")
    restarts = "[restarts]\ncore_in_10_s = 100\nall_in_60_s = 1000\n\n[[models]]"
    pathlib.Path(deployment).write_text(text.replace("[[models]]", restarts, 1))
    scenario = str(ROOT / "config/scenarios/four.toml")
    dice = random.Random(options.seed)
    log = open(options.out / "soak.log", "w")
    service = subprocess.Popen([options.program, "serve", deployment, "--instance", INSTANCE],
                               stderr=log, stdout=log)
    query = [options.program, "query", deployment, scenario, "--instance", INSTANCE, "--json"]
    while top(options.program, deployment) is None:
        if service.poll() is not None:
            sys.exit("the service did not start: see soak.log")
        time.sleep(0.2)
    end = time.monotonic() + 60 * options.minutes
    begun = time.monotonic()
    steady = {"patient": ["--repeat", "1000", "--deadline-ms", "1000"],
              "hasty": ["--repeat", "1000", "--deadline-ms", "4"]}
    running, documents, samples, kills, single = {}, [], [], 0, {}
    seen = None
    while time.monotonic() < end:
        for name, more in steady.items():
            if name not in running:
                running[name] = subprocess.Popen(query + more, stdout=subprocess.PIPE, text=True,
                                                 stderr=log)
            elif running[name].poll() is not None:
                documents.append((name, json.loads(running.pop(name).stdout.read())))
        one = subprocess.run(query, capture_output=True, text=True, check=False)
        single[one.returncode] = single.get(one.returncode, 0) + 1
        workers = children(service.pid)
        if workers:
            os.kill(dice.choice(workers), signal.SIGKILL)
            kills += 1
        memory, descriptors = held(service.pid)
        of_workers = 0
        for worker in children(service.pid):
            try:
                of_workers += held(worker)[0]
            except OSError:
                pass  # It has just ended.
        seen = top(options.program, deployment) or seen
        samples.append({"s": time.monotonic() - begun, "resident_mb": memory,
                        "workers_mb": of_workers, "descriptors": descriptors, "names": names()})
        # `top` waits for a message that comes once a second.
    for process in running.values():
        process.kill()
        process.wait()
    service.send_signal(signal.SIGTERM)
    code = service.wait()
    draw(samples, options.out / "soak.svg")
    answers = [sum(d["answers"][kind] for _, d in documents) for kind in range(5)]
    summary = {
        "minutes": (samples[-1]["s"]) / 60,
        "workers_killed": kills,
        "answers": dict(zip(["complete", "certified", "degraded", "refused", "busy"], answers)),
        "wrong": sum(d["wrong"] for _, d in documents),
        "single_queries_by_exit_code": single,
        "service": seen,
        "resident_mb": flat(samples, "resident_mb"),
        "descriptors": flat(samples, "descriptors"),
        "names": flat(samples, "names"),
        "exit_code": code,
        "names_left": names(),
    }
    (options.out / "soak.json").write_text(json.dumps(summary, indent=2) + "\n")
    print(json.dumps(summary, indent=2))
    sys.exit(0 if summary["wrong"] == 0 and code == 0 and summary["names_left"] == 0 else 1)


INSTANCE = f"soak{os.getpid() % 10000}"
if __name__ == "__main__":
    main()

"""Studies of many scenes, shard by shard, on whatever runs functions: `trolley study` plans them.

Every engine calls one function, `run_shard`. It is idempotent: a finished shard is skipped, an
unfinished one leaves nothing behind but the note that it was begun, and its rows are the same
whoever ranks it. A scene that cannot be ranked is a row with the reason; one that takes its process
down is such a row after three tries.

In a shell::

    python -m trolley_av.study DIR --ray ADDRESS                  # all shards, on a Ray cluster
    python -m trolley_av.study DIR --shard "$SLURM_ARRAY_TASK_ID" --of "$SLURM_ARRAY_TASK_COUNT"
    python -m trolley_av.study DIR --shard "$JOB_COMPLETION_INDEX" --of 64
    python -m trolley_av.study DIR                                # all shards, in this process

DIR is the folder of a study, which all machines must see at the same path, or the URL of an object
store, such as s3://bucket/study, with the extra trolley-av[store]. All need the same build of this
package.
"""

import argparse
import json
import os
import signal
import sys
import tempfile
import time

from . import _core, _store
from ._errors import InputError, TrolleyError

__all__ = ["check", "plan", "run_on_ray", "run_shard", "status"]


def plan(spec, folder):
    """Plan a study: gather its inputs, and write its folder.

    Args:
        spec: the path of the specification: `trolley help study`.
        folder: where the study shall be, a folder or a URL; if it is there already, nothing is
            done.

    Returns:
        As `status`.
    """
    if not _store.is_url(folder):
        return json.loads(_core.study_plan(spec, folder))
    with tempfile.TemporaryDirectory(prefix="trolley-plan-") as local:
        planned = json.loads(_core.study_plan(spec, local))
        try:
            known = status(folder)
        except InputError as error:
            if error.exit_code == 78:
                raise
            _store.put(local, folder)
            return planned
    if known["study"] != planned["study"]:
        raise InputError(f"{folder} holds another study", remedy="name another place", exit_code=65)
    return known


def run_shard(folder, shard):
    """Run one shard of a study, unless it is finished.

    Args:
        folder: the folder of the study, or its URL.
        shard: the number of the shard, from 0.

    Returns:
        A dict: ``shard``, ``rows`` (of the tables answers, candidates, persons), ``refused`` (rows
        that are refusals), ``rows_hash``, and ``was_finished``.
    """
    if _store.is_url(folder):
        return json.loads(_store.at(folder).run_shard(shard))
    return json.loads(_core.study_run_shard(folder, shard))


def status(folder):
    """Say how far a study is.

    Args:
        folder: the folder of the study, or its URL.

    Returns:
        A dict: among others ``shards``, ``finished``, ``broken``, ``scenes``, ``attempts`` (how
        often shards were begun), ``deaths``, and ``rows_hash``, the hash of all rows once all
        shards are finished.
    """
    if _store.is_url(folder):
        folder = _store.at(folder).get_shards()
    return json.loads(_core.study_status(folder))


def check(folder, *, redo=True, ranked_every=None):
    """Hold every byte of a study against what was written.

    Args:
        folder: the folder of the study, or its URL.
        redo: whether shards that are not sound are ranked again.
        ranked_every: rows whose numbers are multiples of it are ranked again, each from files.

    Returns:
        A dict: ``sound``, ``absent``, ``broken`` with the faults of each shard, and ``reranked``
        with ``rows``, and ``differ``, those that `trolley rank` has otherwise.
    """
    if not _store.is_url(folder):
        return json.loads(_core.study_check(folder, redo, ranked_every))
    store = _store.at(folder)
    checked = json.loads(_core.study_check(store.get_shards(), redo, ranked_every))
    for broken in checked["broken"]:
        if broken["is_redone"]:
            store.put_shard(broken["shard"])
    return checked


def run_on_ray(folder, address, *, tries=20, told=None):
    """Run all shards of a study on a Ray cluster: a task for each, as many at once as have room.

    A task whose worker or node dies is begun again, up to `tries` times for each shard; then the
    shard is given up, and the others go on. Ray itself retries nothing.

    Clusters without authentication let anybody on the network run programs: unless
    ``RAY_AUTH_MODE`` says otherwise, this asks for a token (``RAY_AUTH_TOKEN``, or Ray's file).
    Ray's usage statistics are off unless ``RAY_USAGE_STATS_ENABLED`` says otherwise.

    Args:
        folder: the folder of the study, at the same path on all nodes, or its URL.
        address: of the cluster, as "10.0.0.1:6379"; "auto" finds one on this machine.
        tries: how often a shard is begun at most. A scene that takes its process down needs three.
        told: called with the dict of each finished shard, with ``cpu_s``, its CPU time (s).

    Returns:
        A dict of shards that are not finished: their number, and why.
    """
    ray = _ray()
    folder = _absolute(folder)
    shards = range(status(folder)["shards"])
    ray.init(address=address, log_to_driver=False, logging_level="warning",
             namespace="trolley")
    try:
        return _on_ray(ray, folder, list(shards), tries, told or (lambda _: None))
    finally:
        ray.shutdown()


def _absolute(folder):
    return folder if _store.is_url(folder) else os.path.abspath(folder)


def _ray():
    # Read when Ray is imported.
    os.environ.setdefault("RAY_AUTH_MODE", "token")
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray
    except ImportError as error:
        remedy = "pip install 'trolley-av[ray]'"
        raise InputError(f"Ray cannot be imported: {error}", remedy=remedy, exit_code=78) from error
    return ray


def _on_ray(ray, folder, shards, tries, told):
    # By value, so that workers need the installed package alone.
    def task(folder, shard):
        import time
        from trolley_av.study import run_shard as run
        before = time.process_time()
        done = run(folder, shard)
        return {**done, "cpu_s": time.process_time() - before}

    remote = ray.remote(num_cpus=1, max_retries=0)(task)
    waiting, begun, failed, running = list(reversed(shards)), {}, {}, {}
    while waiting or running:
        # A few more than can run, so that nobody waits for this process.
        room = 2 + int(1.25 * ray.cluster_resources().get("CPU", 1))
        while waiting and len(running) < room:
            shard = waiting.pop()
            begun[shard] = begun.get(shard, 0) + 1
            running[remote.remote(folder, shard)] = shard
        done, _ = ray.wait(list(running), num_returns=1, timeout=5.0)
        for reference in done:
            shard = running.pop(reference)
            try:
                told(ray.get(reference))
                failed.pop(shard, None)
            except (ray.exceptions.RayError, TrolleyError) as error:
                failed[shard] = str(error).strip().splitlines()[-1]
                if begun[shard] < tries:
                    waiting.insert(0, shard)
    return failed


def _told_to(out, total):
    """Tells of shards that are done, with the time that is left."""
    began, done = time.monotonic(), [0, 0]

    def told(shard):
        done[0] += 1
        done[1] += not shard["was_finished"]
        passed = time.monotonic() - began
        left = passed / max(done[1], 1) * (total - done[0])
        refused = f", {shard['refused']} refused" if shard["refused"] else ""
        print(f"shard {shard['shard']}: {shard['rows'][0]} answers{refused}; {done[0]} of {total}, "
              f"{left:.0f} s left", file=out, flush=True)

    return told


def _main(arguments=None):
    parser = argparse.ArgumentParser(
        prog="python -m trolley_av.study", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR", help="the folder of a study")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--ray", metavar="ADDRESS", help="run all shards on this Ray cluster")
    where.add_argument("--shard", metavar="K", type=int, help="run shard K alone")
    parser.add_argument("--of", metavar="N", type=int, help="with --shard: K, K + N, K + 2 N, ...")
    parser.add_argument("--tries", metavar="N", type=int, default=20,
                        help="with --ray: begin a shard so often at most (20)")
    given = parser.parse_args(arguments)
    if given.of is not None and (given.shard is None or given.of < 1):
        parser.error("--of goes with --shard, and is 1 or more")
    # A shard that is killed leaves nothing behind.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        return _run(given)
    except TrolleyError as error:
        print(f"trolley_av.study: {error}", file=sys.stderr)
        return error.exit_code


def _run(given):
    folder = _absolute(given.folder)
    total = status(folder)["shards"]
    if given.ray is not None:
        told = _told_to(sys.stderr, total)
        failed = run_on_ray(folder, given.ray, tries=given.tries, told=told)
        for shard, why in sorted(failed.items()):
            print(f"trolley_av.study: shard {shard} is not finished: {why}", file=sys.stderr)
        return 1 if failed else 0
    shards = range(total)
    if given.shard is not None:
        if given.shard < 0 or (given.shard >= total and given.of is None):
            remedy = f"the study has shards 0 to {total - 1}"
            raise InputError(f"--shard is {given.shard}", remedy=remedy, exit_code=64)
        shards = range(given.shard, total, given.of or total)
    told = _told_to(sys.stderr, len(shards))
    for shard in shards:
        told(run_shard(folder, shard))
    return 0


if __name__ == "__main__":
    sys.exit(_main())

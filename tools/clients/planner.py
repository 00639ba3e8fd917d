"""A planner in Python, on the iceoryx2 package alone: asks what config/scenarios/minimal.toml asks.

    pip install iceoryx2==0.10.0
    trolley serve config/deployments/minimal.toml
    python tools/clients/planner.py [INSTANCE [FOLDER]]

The structs are those of crates/protocol/src/public.rs. They have a fixed size: iceoryx2's Python
Slice counts bytes, not items, and its samples have to be deleted.
"""

import ctypes
import secrets
import sys
import time
from ctypes import c_char, c_double, c_uint32, c_uint64

import iceoryx2 as iox2


class Motion(ctypes.Structure):
    _fields_ = [
        ("position_m", c_double * 3),
        ("angles_deg", c_double * 3),
        ("velocity_m_s", c_double * 2),
    ]


class Candidate(ctypes.Structure):
    _fields_ = [
        ("party", c_uint32),
        ("spare", c_uint32),
        ("probability", c_double),
        ("ego", Motion),
        ("other", Motion),
    ]


class Party(ctypes.Structure):
    _fields_ = [
        ("model", c_uint32),
        ("flags", c_uint32),
        ("mass_kg", c_double),
        ("responsibility", c_double),
        ("crush", c_double * 2),
    ]


class Person(ctypes.Structure):
    _fields_ = [("party", c_uint32), ("seat", c_uint32)]


class Ask(ctypes.Structure):
    _fields_ = [
        ("version", c_uint32),
        ("candidate_count", c_uint32),
        ("party_count", c_uint32),
        ("person_count", c_uint32),
        ("sequence", c_uint64),
        ("answer_by_ns", c_uint64),
        ("flags", c_uint32),
        ("ego", c_uint32),
        ("parties", Party * 17),
        ("persons", Person * 64),
        ("candidates", Candidate * 16),
    ]

    @staticmethod
    def type_name() -> str:
        return "trolley.Ask.v1"


class Place(ctypes.Structure):
    _fields_ = [
        ("candidate", c_uint32),
        ("flags", c_uint32),
        ("work", c_double * 2),
        ("range", c_double * 2),
        ("depth_m", c_double * 2),
        ("ego_delta_v_m_s", c_double * 2),
        ("other_delta_v_m_s", c_double * 2),
        ("worst_party", c_uint32),
        ("worst_seat", c_uint32),
        ("worst", c_double * 2),
    ]


class Answer(ctypes.Structure):
    _fields_ = [
        ("version", c_uint32),
        ("verdict", c_uint32),
        ("reason", c_uint32),
        ("place_count", c_uint32),
        ("sequence", c_uint64),
        ("request", c_uint64),
        ("queued_ns", c_uint64),
        ("worked_ns", c_uint64),
        ("text", c_char * 176),
        ("places", Place * 16),
    ]

    @staticmethod
    def type_name() -> str:
        return "trolley.Answer.v1"


assert ctypes.sizeof(Ask) == 3536 and ctypes.sizeof(Answer) == 2016

VERDICTS = ["?", "complete", "certified", "degraded", "refused", "busy"]
NAMES = ["wall, frontal", "pole, narrow"]


def config_of(instance: str, folder: str) -> "iox2.Config":
    """A service's domain: its prefix and its root. Only the service cleans up."""
    config = iox2.config.default()
    config.global_cfg.prefix = iox2.FileName.new(f"trolley-{instance}.")
    config.global_cfg.root_path = iox2.Path.new(f"{folder}/trolley-{instance}")
    config.global_cfg.node.cleanup_dead_nodes_on_creation = False
    config.global_cfg.node.cleanup_dead_nodes_on_destruction = False
    return config


def what_is_left() -> Ask:
    ask = Ask(version=1, party_count=3, candidate_count=2, ego=0)
    # Ids of config/deployments/minimal.toml: 1 a sedan, 2 a wall, 3 a pole.
    for number, model in enumerate([1, 3, 2]):
        ask.parties[number].model = model
    for number, (party, x, y, yaw) in enumerate([(2, 2.55, 0.0, 90.0), (1, 2.4, 0.3, 0.0)]):
        candidate = ask.candidates[number]
        candidate.party, candidate.probability = party, 1.0
        candidate.ego.velocity_m_s[0] = 10.0
        candidate.other.position_m[0], candidate.other.position_m[1] = x, y
        candidate.other.angles_deg[0] = yaw
    return ask


def main() -> int:
    instance = sys.argv[1] if len(sys.argv) > 1 else "minimal"
    folder = sys.argv[2] if len(sys.argv) > 2 else "/dev/shm"
    iox2.set_log_level(iox2.LogLevel.Fatal)
    config = config_of(instance, folder)
    node = iox2.NodeBuilder.new().config(config).create(iox2.ServiceType.Ipc)
    rank = (
        node.service_builder(iox2.ServiceName.new("trolley/rank/v1"))
        .request_response(Ask, Answer)
        .open()
    )
    wake = node.service_builder(iox2.ServiceName.new("trolley/wake/v1")).event().open()
    client = rank.client_builder().create()
    bell = wake.notifier_builder().create()

    end_ns = time.monotonic_ns() + 1_000_000_000
    ask = what_is_left()
    # A number that no other client chooses: whoever was killed here before may still be answered.
    ask.sequence, ask.answer_by_ns = secrets.randbits(64), end_ns
    request = client.loan_uninit().write_payload(ask)
    pending = request.send()
    bell.notify()
    while time.monotonic_ns() < end_ns:
        response = pending.receive()
        if response is not None:
            answer = Answer.from_buffer_copy(response.payload().contents)
            response.delete()
            if answer.sequence == ask.sequence:
                break
        time.sleep(0.0001)
    else:
        print("refused: no answer arrived in time", file=sys.stderr)
        return 4
    print(VERDICTS[answer.verdict], answer.text.decode(), file=sys.stderr)
    for number in range(answer.place_count):
        place = answer.places[number]
        print(number + 1, NAMES[place.candidate], repr(place.work[0]), repr(place.work[1]))
    return 0 if answer.verdict <= 2 else 4


if __name__ == "__main__":
    sys.exit(main())

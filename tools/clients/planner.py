"""A planner in Python, on the C library: asks what config/scenarios/minimal.toml asks.

    cargo build --release -p trolley-client-c
    trolley serve config/deployments/minimal.toml
    LD_LIBRARY_PATH=target/release python3 tools/clients/planner.py [INSTANCE [FOLDER]]

The structs are those of crates/client-c/include/trolley.h. They have a fixed size.
"""

import ctypes
import sys
from ctypes import POINTER, c_char, c_char_p, c_double, c_size_t, c_uint32, c_uint64, c_void_p


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


assert ctypes.sizeof(Ask) == 3536 and ctypes.sizeof(Answer) == 2016

VERDICTS = ["?", "complete", "certified", "degraded", "refused", "busy"]
NAMES = ["wall, frontal", "pole, narrow"]


def library() -> ctypes.CDLL:
    """The C library, with the types of its three functions."""
    lib = ctypes.CDLL("libtrolley_client.so")
    lib.trolley_connect.argtypes = [c_char_p, c_char_p, c_uint64, c_char_p, c_size_t]
    lib.trolley_connect.restype = c_void_p
    lib.trolley_ask.argtypes = [c_void_p, POINTER(Ask), c_uint64, POINTER(Answer)]
    lib.trolley_ask.restype = None
    lib.trolley_disconnect.argtypes = [c_void_p]
    lib.trolley_disconnect.restype = None
    return lib


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
    folder = sys.argv[2].encode() if len(sys.argv) > 2 else None
    lib = library()
    why = ctypes.create_string_buffer(512)
    client = lib.trolley_connect(folder, instance.encode(), 100_000, why, len(why))
    if not client:
        print(why.value.decode(), file=sys.stderr)
        return 75
    answer = Answer()
    lib.trolley_ask(client, what_is_left(), 1_000_000_000, answer)
    lib.trolley_disconnect(client)
    print(VERDICTS[answer.verdict], answer.text.decode(), file=sys.stderr)
    for number in range(answer.place_count):
        place = answer.places[number]
        print(number + 1, NAMES[place.candidate], repr(place.work[0]), repr(place.work[1]))
    return 0 if answer.verdict <= 2 else 4


if __name__ == "__main__":
    sys.exit(main())

"""A planner in Python, on the C library: asks what config/scenarios/wall-or-pole.toml asks.

    cargo build --release -p trolley-client-c
    trolley serve config/deployments/minimal.toml
    LD_LIBRARY_PATH=target/release python3 tools/clients/planner.py [INSTANCE [FOLDER [MEMBERS]]]

An empty FOLDER is the default one. With MEMBERS it is ranked over draws of what is known only up to
errors. The structs are those of crates/client-c/include/trolley.h. They have a fixed size.
"""

import ctypes
import sys
from ctypes import POINTER, c_char, c_char_p, c_double, c_size_t, c_uint8, c_uint32, c_uint64
from ctypes import c_void_p


class State(ctypes.Structure):
    _fields_ = [
        ("t_s", c_double),
        ("position_m", c_double * 3),
        ("angles_deg", c_double * 3),
        ("velocity_m_s", c_double * 2),
        ("flags", c_uint64),
    ]


class Path(ctypes.Structure):
    _fields_ = [
        ("kind", c_uint32),
        ("first_state", c_uint32),
        ("state_count", c_uint32),
        ("spare", c_uint32),
        ("probability", c_double),
        ("yaw_rate_deg_s", c_double),
    ]


class Candidate(ctypes.Structure):
    _fields_ = [
        ("path", c_uint32),
        ("first_reaction", c_uint32),
        ("reaction_count", c_uint32),
        ("spare", c_uint32),
    ]


class Reaction(ctypes.Structure):
    _fields_ = [("party", c_uint32), ("path", c_uint32)]


class Party(ctypes.Structure):
    _fields_ = [
        ("model", c_uint32),
        ("flags", c_uint32),
        ("first_path", c_uint32),
        ("path_count", c_uint32),
        ("mass_kg", c_double),
        ("responsibility", c_double),
        ("crush", c_double * 2),
        ("size_m", c_double * 3),
        ("lateral_m", c_double),
        ("longitudinal_m", c_double),
        ("correlation", c_double),
        ("yaw_deg", c_double),
        ("speed_share", c_double),
        ("room", c_uint64),
    ]


class Persons(ctypes.Structure):
    _fields_ = [("party", c_uint32), ("seat", c_uint32), ("count", c_uint32), ("spare", c_uint32)]


class Ask(ctypes.Structure):
    _fields_ = [
        ("version", c_uint32),
        ("flags", c_uint32),
        ("sequence", c_uint64),
        ("answer_by_ns", c_uint64),
        ("checksum", c_uint64),
        ("ego", c_uint32),
        ("party_count", c_uint32),
        ("person_count", c_uint32),
        ("candidate_count", c_uint32),
        ("path_count", c_uint32),
        ("reaction_count", c_uint32),
        ("state_count", c_uint32),
        ("members", c_uint32),
        ("horizon_s", c_double),
        ("resolution_m", c_double),
        ("model_set", c_uint8 * 32),
        ("members_max", c_uint32),
        ("spare", c_uint32),
        ("room", c_uint64),
        ("parties", Party * 32),
        ("persons", Persons * 256),
        ("candidates", Candidate * 16),
        ("reactions", Reaction * 128),
        ("paths", Path * 256),
        ("states", State * 7168),
    ]


class Contact(ctypes.Structure):
    _fields_ = [
        ("party", c_uint32),
        ("flags", c_uint32),
        ("time_s", c_double),
        ("closing_m_s", c_double),
        ("ego_delta_v_m_s", c_double * 2),
        ("other_delta_v_m_s", c_double * 2),
    ]


class Met(ctypes.Structure):
    _fields_ = [
        ("party", c_uint32),
        ("spare", c_uint32),
        ("probability", c_double),
        ("from_s", c_double),
    ]


class Expected(ctypes.Structure):
    _fields_ = [
        ("contact", c_double),
        ("injured", c_double * 2),
        ("error", c_double),
        ("quantiles", c_double * 3),
        ("best", c_double),
        ("regret", c_double),
        ("worlds", c_double),
        ("open", c_uint32),
        ("undecided", c_uint32),
        ("met_count", c_uint32),
        ("spare", c_uint32),
        ("meets", Met * 8),
    ]


class Place(ctypes.Structure):
    _fields_ = [
        ("candidate", c_uint32),
        ("flags", c_uint32),
        ("work", c_double * 2),
        ("range", c_double * 2),
        ("contact_count", c_uint32),
        ("worst_party", c_uint32),
        ("worst_seat", c_uint32),
        ("nearest_party", c_uint32),
        ("worst", c_double * 2),
        ("open_from_s", c_double),
        ("nearest_m", c_double),
        ("nearest_s", c_double),
        ("contacts", Contact * 4),
        ("expected", Expected),
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
        ("checksum", c_uint64),
        ("flags", c_uint32),
        ("members", c_uint32),
        ("members_max", c_uint32),
        ("replaced", c_uint32),
        ("worlds", c_uint32),
        ("spare", c_uint32),
        ("lead", c_double),
        ("lead_error", c_double),
        ("model_set", c_uint8 * 32),
        ("text", c_char * 160),
        ("places", Place * 16),
    ]


assert ctypes.sizeof(Ask) == 590976 and ctypes.sizeof(Answer) == 10016
assert Ask.states.offset == 17536 and Answer.places.offset == 288

PLACE, ONWARD, STATES = 1, 2, 3
VELOCITY = 1
# Of a party: which errors are set; without its flag the usual one applies.
LATERAL, LONGITUDINAL, CORRELATION, YAW, SPEED = 16, 32, 64, 128, 256
ERRORS = {
    "lateral_m": LATERAL,
    "longitudinal_m": LONGITUDINAL,
    "correlation": CORRELATION,
    "yaw_deg": YAW,
    "speed_share": SPEED,
}
# Of an answer, and of a place.
LATE, LEAD, WORLDS = 1, 2, 4
MEMBERS, SPREAD = 256, 512
VERDICTS = ["?", "complete", "certified", "degraded", "refused", "busy"]
NAMES = ["straight on, the wall", "to the left, the pole", "brake"]
LEFT = [(0.0, 0.0, 0.0, 0.0), (0.5, 7.0, 0.4, 6.0), (1.0, 13.8, 1.8, 14.0), (1.5, 20.4, 4.0, 20.0)]
BRAKE = [(0.0, 0.0), (0.5, 6.3), (1.0, 11.2), (1.5, 14.7), (2.0, 16.8), (2.5, 17.5), (2.6, 17.5)]


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


def at(t_s: float, x: float, y: float, yaw_deg: float) -> State:
    state = State(t_s=t_s)
    state.position_m[0], state.position_m[1], state.angles_deg[0] = x, y, yaw_deg
    return state


def set_members(ask: Ask, members: int, members_max: int = 0) -> None:
    """Asks for expected harm over so many members, and at most so many; 0: the service's own."""
    ask.members, ask.members_max = members, members_max


def set_errors(party: Party, **errors: float) -> None:
    """States standard deviations of a party by the names in ERRORS; others stay as they are."""
    for name, value in errors.items():
        party.flags |= ERRORS[name]
        setattr(party, name, value)


def expected(place: Place):
    """What members say of a candidate; None: none were drawn. What is not known is NaN."""
    return place.expected if place.flags & MEMBERS else None


def met(of: Expected) -> list:
    """The parties that a candidate meets in some members, the most probable first."""
    return [(row.party, row.probability, row.from_s) for row in of.meets[: min(of.met_count, 8)]]


def lead(answer: Answer):
    """By how much the second is worse in the mean, and its sampling error, if known."""
    return (answer.lead, answer.lead_error) if answer.flags & LEAD else None


def add_path(ask: Ask, kind: int, states: list, probability: float = 0.0) -> int:
    """Adds a path, and returns its number."""
    number, first = ask.path_count, ask.state_count
    ask.paths[number] = Path(
        kind=kind, first_state=first, state_count=len(states), probability=probability
    )
    for place, state in enumerate(states, first):
        ask.states[place] = state
    ask.path_count, ask.state_count = number + 1, first + len(states)
    return number


def what_is_left() -> Ask:
    ask = Ask(version=3, horizon_s=5.0, party_count=3, candidate_count=3, ego=0)
    # Ids of config/deployments/minimal.toml: 1 a sedan, 2 a wall, 3 a pole.
    ask.parties[0].model = 1
    for number, model, place in [(1, 3, at(0.0, 20.0, 2.9, 0.0)), (2, 2, at(0.0, 25.0, 0.0, 90.0))]:
        party = ask.parties[number]
        party.model, party.path_count = model, 1
        party.first_path = add_path(ask, PLACE, [place], 1.0)
    # What localisation and tracking say of themselves; of the wall they say nothing.
    set_errors(
        ask.parties[0],
        lateral_m=0.1,
        longitudinal_m=0.5,
        correlation=0.25,
        yaw_deg=1.5,
        speed_share=0.08,
    )
    set_errors(ask.parties[1], lateral_m=0.4, longitudinal_m=0.6, correlation=0.0)
    now = at(0.0, 0.0, 0.0, 0.0)
    now.velocity_m_s[0], now.flags = 14.0, VELOCITY
    ask.candidates[0].path = add_path(ask, ONWARD, [now])
    ask.candidates[1].path = add_path(ask, STATES, [at(*state) for state in LEFT])
    ask.candidates[2].path = add_path(ask, STATES, [at(t_s, x, 0.0, 0.0) for t_s, x in BRAKE])
    return ask


def main() -> int:
    instance = sys.argv[1] if len(sys.argv) > 1 else "minimal"
    folder = sys.argv[2].encode() if len(sys.argv) > 2 else None
    members = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    lib = library()
    why = ctypes.create_string_buffer(512)
    client = lib.trolley_connect(folder, instance.encode(), 100_000, why, len(why))
    if not client:
        print(why.value.decode(), file=sys.stderr)
        return 75
    answer = Answer()
    ask = what_is_left()
    set_members(ask, members, members)
    lib.trolley_ask(client, ask, 1_000_000_000, answer)
    lib.trolley_disconnect(client)
    print(VERDICTS[answer.verdict], answer.text.decode(), file=sys.stderr)
    for number in range(answer.place_count):
        place = answer.places[number]
        figures = [place.work[0], place.work[1]]
        of = expected(place)
        if of is not None:
            figures += [of.contact, *of.injured, of.error, *of.quantiles]
            figures += [of.best, of.regret, of.worlds]
            figures += [figure for row in met(of) for figure in row]
        print(number + 1, NAMES[place.candidate] + ":", *map(repr, figures))
    if lead(answer) is not None:
        print(answer.members, "members:", *map(repr, lead(answer)))
    return 0 if answer.verdict <= 2 else 4


if __name__ == "__main__":
    sys.exit(main())

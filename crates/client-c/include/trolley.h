/* Trolley: ranks unavoidable collisions by harm. For C11 and C++11.
 *
 * Link with -ltrolley_client. The structs are those that travel through shared memory: fixed size,
 * no pointers, no hidden padding. Lengths in metres, angles in degrees, speeds in m/s, times of a
 * request in seconds from now, others in nanoseconds on CLOCK_MONOTONIC. Zero everything, then fill
 * in what counts. A request is larger than some stacks: allocate it, or make it static.
 */
#ifndef TROLLEY_H
#define TROLLEY_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define TROLLEY_ASSERT(holds) static_assert(holds, #holds)
#else
#define TROLLEY_ASSERT(holds) _Static_assert(holds, #holds)
#endif

#define TROLLEY_VERSION 3u
#define TROLLEY_CANDIDATES_MAX 16
#define TROLLEY_PARTIES_MAX 32 /* the ego among them */
#define TROLLEY_PERSONS_MAX 256
#define TROLLEY_PATHS_MAX 256
#define TROLLEY_PATHS_PER_PARTY_MAX 3
#define TROLLEY_REACTIONS_MAX 128
#define TROLLEY_STATES_MAX 7168
#define TROLLEY_STATES_PER_PATH_MAX 64
#define TROLLEY_CONTACTS_MAX 4 /* of a candidate, in an answer */
#define TROLLEY_MET_MAX 8      /* parties that a candidate meets in some members, in an answer */

/* trolley_answer.verdict */
#define TROLLEY_COMPLETE 1u  /* all work is done */
#define TROLLEY_CERTIFIED 2u /* no open work can change the winner */
#define TROLLEY_DEGRADED 3u  /* it could; the intervals hold all the same */
#define TROLLEY_REFUSED 4u   /* no ranking: see reason and text */
#define TROLLEY_BUSY 5u      /* no ranking: ask again */

/* trolley_answer.reason */
#define TROLLEY_REASON_NONE 0u
#define TROLLEY_REASON_MALFORMED 1u
#define TROLLEY_REASON_UNKNOWN_MODEL 2u
#define TROLLEY_REASON_OUT_OF_RANGE 3u
#define TROLLEY_REASON_MISFIT 4u
#define TROLLEY_REASON_UNKNOWN_KIND 5u
#define TROLLEY_REASON_UNASSESSABLE 6u
#define TROLLEY_REASON_TOO_LATE 7u
#define TROLLEY_REASON_QUEUE_FULL 8u
#define TROLLEY_REASON_NO_WORKERS 9u
#define TROLLEY_REASON_STOPPING 10u
#define TROLLEY_REASON_INTERNAL 11u
#define TROLLEY_REASON_SILENCE 12u    /* from this library: no answer arrived in time */
#define TROLLEY_REASON_NO_SERVICE 13u /* from this library: there is no service */
#define TROLLEY_REASON_CORRUPT 14u    /* a bit was changed on the way: ask again */
#define TROLLEY_REASON_OTHER_MODELS 15u
#define TROLLEY_REASON_NONE_ACCEPTABLE 16u /* by the policy, which lets none be chosen */

/* trolley_request.flags */
#define TROLLEY_UNKNOWN_IS_FIXED 1u

/* trolley_party.flags: which fields count */
#define TROLLEY_PARTY_PERSONS 1u /* its persons are those listed; else its model's, or the usual */
#define TROLLEY_PARTY_MASS 2u
#define TROLLEY_PARTY_UNKNOWN 4u
#define TROLLEY_PARTY_CRUSH 8u
#define TROLLEY_PARTY_LATERAL 16u /* this error and those below: without its flag the usual one */
#define TROLLEY_PARTY_LONGITUDINAL 32u
#define TROLLEY_PARTY_CORRELATION 64u
#define TROLLEY_PARTY_YAW 128u
#define TROLLEY_PARTY_SPEED 256u

/* trolley_persons.seat */
#define TROLLEY_ON_FOOT 0u /* or on some seat */
#define TROLLEY_FRONT_LEFT 1u
#define TROLLEY_FRONT_RIGHT 2u
#define TROLLEY_REAR_LEFT 3u
#define TROLLEY_REAR_MIDDLE 4u
#define TROLLEY_REAR_RIGHT 5u
#define TROLLEY_RIDER 6u
#define TROLLEY_PILLION 7u

/* trolley_path.kind */
#define TROLLEY_PATH_PLACE 1u  /* stands: one state */
#define TROLLEY_PATH_ONWARD 2u /* goes on as it moves: one state with its velocity; yaw rate */
#define TROLLEY_PATH_STATES 3u /* goes through 1 to 64 states, in the order of their times */

/* trolley_state.flags */
#define TROLLEY_STATE_VELOCITY 1u

/* trolley_answer.flags */
#define TROLLEY_LATE 1u   /* more members were begun and not finished in time */
#define TROLLEY_LEAD 2u   /* lead and lead_error count */
#define TROLLEY_WORLDS 4u /* the shares of worlds count */

/* trolley_place.flags */
#define TROLLEY_TOUCHES_NOBODY 1u /* until the end of its way, in every member: proven */
#define TROLLEY_CERTAIN 2u        /* it certainly comes before the next */
#define TROLLEY_TIED 4u           /* the model cannot distinguish it from the first */
#define TROLLEY_UNEVALUABLE 8u    /* a contact has no figures */
#define TROLLEY_OPEN 16u          /* from open_from_s on it is not known what happens */
#define TROLLEY_NEAREST 32u       /* the figures of the nearest party count */
#define TROLLEY_PERSON 64u        /* the worst-off person's figures count */
#define TROLLEY_ALTERNATIVE 128u  /* on a predicted path that was not followed, it meets somebody */
#define TROLLEY_MEMBERS 256u      /* members were followed: expected counts; work, range and worst are
                                   * means over them, all else is of the scene as stated */
#define TROLLEY_SPREAD 512u       /* nothing of any member is open: its spread counts */
#define TROLLEY_STATED_ALONE 1024u /* no time for members: all is of the scene as stated */

/* trolley_contact.flags */
#define TROLLEY_HEAVY 1u        /* the ego runs out from there; otherwise it drives on */
#define TROLLEY_MAY_BE_OTHER 2u /* the range of the model holds both */
#define TROLLEY_AT_START 4u     /* in contact at the start */
#define TROLLEY_TOUCHES 8u      /* triangles touch; otherwise within the resolution */
#define TROLLEY_FIXED 16u       /* the party is fixed to the ground */

/* Where a body is at one time. */
typedef struct trolley_state {
  double t_s;             /* from now */
  double position_m[3];   /* of the body frame's origin, in the world */
  double angles_deg[3];   /* yaw, pitch, roll, in the order Z, Y, X */
  double velocity_m_s[2]; /* in the ground plane of the world, with TROLLEY_STATE_VELOCITY */
  uint64_t flags;
} trolley_state;

/* Consecutive states, and how they are meant. */
typedef struct trolley_path {
  uint32_t kind;
  uint32_t first_state;
  uint32_t state_count;
  uint32_t spare;        /* 0 */
  double probability;    /* of a predicted path; those of a party sum to 1 */
  double yaw_rate_deg_s; /* of TROLLEY_PATH_ONWARD */
} trolley_path;

/* A manoeuvre that may be chosen. */
typedef struct trolley_candidate {
  uint32_t path; /* the ego's */
  uint32_t first_reaction;
  uint32_t reaction_count;
  uint32_t spare; /* 0 */
} trolley_candidate;

/* The motion of a party in one candidate, instead of all that are predicted. */
typedef struct trolley_reaction {
  uint32_t party;
  uint32_t path;
} trolley_reaction;

/* A physical body that may be hit. */
typedef struct trolley_party {
  uint32_t model; /* id in the deployment file */
  uint32_t flags;
  uint32_t first_path; /* of those predicted; of the ego 0 */
  uint32_t path_count; /* 1 to 3; of the ego 0: its motion is in the candidates */
  double mass_kg;
  double responsibility;            /* 0 to 1 */
  double crush[2];                  /* stiffness A (N/m) and B (N/m^2) */
  double size_m[3];                 /* room: 0 */
  double lateral_m;                 /* standard deviations, each 0 without its flag: to its left, */
  double longitudinal_m;            /* along its x axis, both 0 to 10 m; */
  double correlation;               /* correlation of the two, -1 to 1; */
  double yaw_deg;                   /* of its yaw, 0 to 90; */
  double speed_share;               /* of the logarithm of a factor on its speed, 0 to 0.5 */
  uint64_t room;                    /* 0 */
} trolley_party;

typedef struct trolley_persons {
  uint32_t party;
  uint32_t seat;
  uint32_t count; /* 1 to 90; on a seat 1 */
  uint32_t spare; /* 0 */
} trolley_persons;

typedef struct trolley_request {
  uint32_t version; /* TROLLEY_VERSION */
  uint32_t flags;
  uint64_t sequence;     /* set by the library */
  uint64_t answer_by_ns; /* set by the library */
  uint64_t checksum;     /* set by the library */
  uint32_t ego; /* number of the party that is the automated vehicle */
  uint32_t party_count;
  uint32_t person_count;
  uint32_t candidate_count;
  uint32_t path_count;
  uint32_t reaction_count;
  uint32_t state_count;
  uint32_t members;      /* up to 1024; 1: the scene as stated; 0: as the service usually does */
  double horizon_s;      /* how far ahead to look, up to 30 */
  double resolution_m;   /* 0: 1 mm */
  uint8_t model_set[32]; /* of an earlier answer: refuse if the service has other bodies; or 0 */
  uint32_t members_max;  /* where the best two are too close to call; 0: 128, or members if more,
                          * and with members 0 as the service usually does */
  uint32_t spare;        /* 0 */
  uint64_t room;         /* 0 */
  trolley_party parties[TROLLEY_PARTIES_MAX];
  trolley_persons persons[TROLLEY_PERSONS_MAX];
  trolley_candidate candidates[TROLLEY_CANDIDATES_MAX];
  trolley_reaction reactions[TROLLEY_REACTIONS_MAX];
  trolley_path paths[TROLLEY_PATHS_MAX];
  trolley_state states[TROLLEY_STATES_MAX];
} trolley_request;

/* Whom the ego meets. Pairs are the ends of an interval. */
typedef struct trolley_contact {
  uint32_t party;
  uint32_t flags;
  double time_s;
  double closing_m_s;
  double ego_delta_v_m_s[2];
  double other_delta_v_m_s[2];
} trolley_contact;

/* A party that a candidate meets in some members. */
typedef struct trolley_met {
  uint32_t party;
  uint32_t spare;
  double probability; /* the share of members; where some are open, the least share */
  double from_s;      /* the earliest contact among them */
} trolley_met;

/* What members say of a candidate. What is not known is NaN. */
typedef struct trolley_expected {
  double contact;      /* share of members in which it meets anybody; of open ones the least */
  double injured[2];   /* persons expected to be injured, as far as the work is done */
  double error;        /* sampling error of the leading measure; with TROLLEY_SPREAD, as all below */
  double quantiles[3]; /* what the measure is below in 5, 50 and 95 % of the members */
  double best;         /* share of members in which it is best */
  double regret;       /* how much more than the best of each member, in the mean */
  double worlds;       /* share of worlds that it wins, with TROLLEY_WORLDS */
  uint32_t open;       /* members that are not followed to their end */
  uint32_t undecided;  /* members in which it is not decided who is inside of whom at the start */
  uint32_t met_count;  /* all; the most probable eight are below */
  uint32_t spare;
  trolley_met meets[TROLLEY_MET_MAX]; /* the most probable first */
} trolley_expected;

/* One candidate of the ranking. */
typedef struct trolley_place {
  uint32_t candidate; /* its number in the request */
  uint32_t flags;
  double work[2];  /* the policy's leading measure, as far as the work is done */
  double range[2]; /* the measure over the uncertainty of the model */
  uint32_t contact_count; /* all; the first four are below */
  uint32_t worst_party;
  uint32_t worst_seat;
  uint32_t nearest_party;
  double worst[2]; /* probability of injury of the person worst off */
  double open_from_s;
  double nearest_m; /* in plan */
  double nearest_s;
  trolley_contact contacts[TROLLEY_CONTACTS_MAX]; /* in the order of time */
  trolley_expected expected;                      /* with TROLLEY_MEMBERS */
} trolley_place;

typedef struct trolley_answer {
  uint32_t version;
  uint32_t verdict;
  uint32_t reason;
  uint32_t place_count; /* 0 without a ranking */
  uint64_t sequence;
  uint64_t request;   /* the service's number of the request */
  uint64_t queued_ns;
  uint64_t worked_ns;
  uint64_t checksum;
  uint32_t flags;
  uint32_t members;     /* that harm is the mean of; 1: the scene as stated; 0 without a ranking */
  uint32_t members_max; /* that there might have been */
  uint32_t replaced;    /* draws in which the ego overlapped somebody */
  uint32_t worlds;      /* that were drawn; 0 without TROLLEY_WORLDS */
  uint32_t spare;
  double lead;       /* of the second over the first, in the mean, with TROLLEY_LEAD; else NaN */
  double lead_error; /* its sampling error */
  uint8_t model_set[32]; /* identity of the service's bodies */
  char text[160]; /* UTF-8, ended by zeros */
  trolley_place places[TROLLEY_CANDIDATES_MAX]; /* least harm first */
} trolley_answer;

TROLLEY_ASSERT(sizeof(trolley_state) == 80);
TROLLEY_ASSERT(sizeof(trolley_path) == 32);
TROLLEY_ASSERT(sizeof(trolley_candidate) == 16);
TROLLEY_ASSERT(sizeof(trolley_reaction) == 8);
TROLLEY_ASSERT(sizeof(trolley_party) == 120);
TROLLEY_ASSERT(sizeof(trolley_persons) == 16);
TROLLEY_ASSERT(sizeof(trolley_request) == 590976);
TROLLEY_ASSERT(offsetof(trolley_request, checksum) == 24);
TROLLEY_ASSERT(offsetof(trolley_party, lateral_m) == 72);
TROLLEY_ASSERT(offsetof(trolley_party, room) == 112);
TROLLEY_ASSERT(offsetof(trolley_request, members) == 60);
TROLLEY_ASSERT(offsetof(trolley_request, horizon_s) == 64);
TROLLEY_ASSERT(offsetof(trolley_request, model_set) == 80);
TROLLEY_ASSERT(offsetof(trolley_request, members_max) == 112);
TROLLEY_ASSERT(offsetof(trolley_request, room) == 120);
TROLLEY_ASSERT(offsetof(trolley_request, parties) == 128);
TROLLEY_ASSERT(offsetof(trolley_request, persons) == 3968);
TROLLEY_ASSERT(offsetof(trolley_request, candidates) == 8064);
TROLLEY_ASSERT(offsetof(trolley_request, reactions) == 8320);
TROLLEY_ASSERT(offsetof(trolley_request, paths) == 9344);
TROLLEY_ASSERT(offsetof(trolley_request, states) == 17536);
TROLLEY_ASSERT(sizeof(trolley_contact) == 56);
TROLLEY_ASSERT(sizeof(trolley_met) == 24);
TROLLEY_ASSERT(sizeof(trolley_expected) == 288);
TROLLEY_ASSERT(offsetof(trolley_expected, open) == 80);
TROLLEY_ASSERT(offsetof(trolley_expected, meets) == 96);
TROLLEY_ASSERT(sizeof(trolley_place) == 608);
TROLLEY_ASSERT(offsetof(trolley_place, contacts) == 96);
TROLLEY_ASSERT(offsetof(trolley_place, expected) == 320);
TROLLEY_ASSERT(sizeof(trolley_answer) == 10016);
TROLLEY_ASSERT(offsetof(trolley_answer, checksum) == 48);
TROLLEY_ASSERT(offsetof(trolley_answer, lead) == 80);
TROLLEY_ASSERT(offsetof(trolley_answer, model_set) == 96);
TROLLEY_ASSERT(offsetof(trolley_answer, text) == 128);
TROLLEY_ASSERT(offsetof(trolley_answer, places) == 288);

typedef struct trolley_client trolley_client;

/* Connects to the service of this instance in this folder (NULL if its deployment file names none).
 * nap_ns: how long to sleep between two polls for an answer; 0: poll continuously. Returns NULL on failure, and then writes why into error, which may be NULL. */
trolley_client *trolley_connect(const char *folder, const char *instance, uint64_t nap_ns,
                                char *error, size_t error_length);

/* Adds a path through these states, and returns its number, or TROLLEY_PATHS_MAX without room. */
static inline uint32_t trolley_add_path(trolley_request *request, uint32_t kind,
                                        const trolley_state *states, uint32_t count) {
  uint32_t number = request->path_count, first = request->state_count, i;
  if (number >= TROLLEY_PATHS_MAX || count > TROLLEY_STATES_MAX - first) return TROLLEY_PATHS_MAX;
  request->paths[number].kind = kind;
  request->paths[number].first_state = first;
  request->paths[number].state_count = count;
  for (i = 0; i < count; i++) request->states[first + i] = states[i];
  request->path_count = number + 1;
  request->state_count = first + count;
  return number;
}

/* Asks for expected harm over so many members, and at most so many; 0: see trolley_request. */
static inline void trolley_set_members(trolley_request *request, uint32_t members,
                                       uint32_t members_max) {
  request->members = members;
  request->members_max = members_max;
}

/* States how well a place is known, with standard deviations to the left and along (m), and their
 * correlation. Without it the usual errors apply: 0.2 m, 0.3 m, 0. */
static inline void trolley_set_place_errors(trolley_party *party, double lateral_m,
                                            double longitudinal_m, double correlation) {
  party->lateral_m = lateral_m;
  party->longitudinal_m = longitudinal_m;
  party->correlation = correlation;
  party->flags |= TROLLEY_PARTY_LATERAL | TROLLEY_PARTY_LONGITUDINAL | TROLLEY_PARTY_CORRELATION;
}

/* States how well a yaw is known (degrees). Without it the usual error applies: 2. */
static inline void trolley_set_yaw_error(trolley_party *party, double yaw_deg) {
  party->yaw_deg = yaw_deg;
  party->flags |= TROLLEY_PARTY_YAW;
}

/* States how well a speed is known, as a share of it. Without it the usual error applies: 0.1, and
 * of the ego 0.05. */
static inline void trolley_set_speed_error(trolley_party *party, double speed_share) {
  party->speed_share = speed_share;
  party->flags |= TROLLEY_PARTY_SPEED;
}

/* What members say of a candidate; NULL: none were drawn. */
static inline const trolley_expected *trolley_expected_of(const trolley_place *place) {
  return (place->flags & TROLLEY_MEMBERS) != 0 ? &place->expected : NULL;
}

/* How many parties of expected.meets are filled in. */
static inline uint32_t trolley_met_listed(const trolley_expected *expected) {
  return expected->met_count < TROLLEY_MET_MAX ? expected->met_count : TROLLEY_MET_MAX;
}

/* Sends a request, and waits at most patience_ns for the answer. There is always an answer: if the
 * service gives none, a refusal made by this library; also if a bit of either was changed on the
 * way. One thread at a time. */
void trolley_ask(trolley_client *client, const trolley_request *request, uint64_t patience_ns,
                 trolley_answer *answer);

/* Ends a client. */
void trolley_disconnect(trolley_client *client);

/* "complete", "certified", ... */
const char *trolley_verdict_name(uint32_t verdict);

#ifdef __cplusplus
} /* extern "C" */
#endif

#endif /* TROLLEY_H */

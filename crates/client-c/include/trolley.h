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

#define TROLLEY_VERSION 2u
#define TROLLEY_CANDIDATES_MAX 16
#define TROLLEY_PARTIES_MAX 32 /* the ego among them */
#define TROLLEY_PERSONS_MAX 256
#define TROLLEY_PATHS_MAX 256
#define TROLLEY_PATHS_PER_PARTY_MAX 3
#define TROLLEY_REACTIONS_MAX 128
#define TROLLEY_STATES_MAX 7168
#define TROLLEY_STATES_PER_PATH_MAX 64
#define TROLLEY_CONTACTS_MAX 4 /* of a candidate, in an answer */

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

/* trolley_place.flags */
#define TROLLEY_TOUCHES_NOBODY 1u /* until the end of its way: proven */
#define TROLLEY_CERTAIN 2u        /* it certainly comes before the next */
#define TROLLEY_TIED 4u           /* the model cannot distinguish it from the first */
#define TROLLEY_UNEVALUABLE 8u    /* a contact has no figures */
#define TROLLEY_OPEN 16u          /* from open_from_s on it is not known what happens */
#define TROLLEY_NEAREST 32u       /* the figures of the nearest party count */
#define TROLLEY_PERSON 64u        /* the worst-off person's figures count */
#define TROLLEY_ALTERNATIVE 128u  /* on a predicted path that was not followed, it meets somebody */

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
  double position_covariance_m2[4]; /* room: 0 */
  double yaw_variance_deg2;         /* room: 0 */
  double speed_variance;            /* room: 0 */
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
  uint32_t spare;        /* 0 */
  double horizon_s;      /* how far ahead to look, up to 30 */
  double resolution_m;   /* 0: 1 mm */
  uint8_t model_set[32]; /* of an earlier answer: refuse if the service has other bodies; or 0 */
  uint64_t room[2];      /* 0 */
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
  uint64_t spare;
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
TROLLEY_ASSERT(offsetof(trolley_request, horizon_s) == 64);
TROLLEY_ASSERT(offsetof(trolley_request, model_set) == 80);
TROLLEY_ASSERT(offsetof(trolley_request, parties) == 128);
TROLLEY_ASSERT(offsetof(trolley_request, persons) == 3968);
TROLLEY_ASSERT(offsetof(trolley_request, candidates) == 8064);
TROLLEY_ASSERT(offsetof(trolley_request, reactions) == 8320);
TROLLEY_ASSERT(offsetof(trolley_request, paths) == 9344);
TROLLEY_ASSERT(offsetof(trolley_request, states) == 17536);
TROLLEY_ASSERT(sizeof(trolley_contact) == 56);
TROLLEY_ASSERT(sizeof(trolley_place) == 320);
TROLLEY_ASSERT(offsetof(trolley_place, contacts) == 96);
TROLLEY_ASSERT(sizeof(trolley_answer) == 5376);
TROLLEY_ASSERT(offsetof(trolley_answer, checksum) == 48);
TROLLEY_ASSERT(offsetof(trolley_answer, model_set) == 64);
TROLLEY_ASSERT(offsetof(trolley_answer, text) == 96);
TROLLEY_ASSERT(offsetof(trolley_answer, places) == 256);

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

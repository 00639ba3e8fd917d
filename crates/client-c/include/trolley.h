/* Trolley: ranks unavoidable collisions by harm. For C11 and C++11.
 *
 * Link with -ltrolley_client. The structs are those that travel through shared memory: fixed size,
 * no pointers, no hidden padding. Lengths in metres, angles in degrees, speeds in m/s, times in
 * nanoseconds on CLOCK_MONOTONIC. Zero everything, then fill in what counts.
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

#define TROLLEY_VERSION 1u
#define TROLLEY_CANDIDATES_MAX 16
#define TROLLEY_PARTIES_MAX 17
#define TROLLEY_PERSONS_MAX 64

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

/* trolley_ask.flags */
#define TROLLEY_UNKNOWN_IS_FIXED 1u

/* trolley_party.flags: which fields count */
#define TROLLEY_PARTY_PERSONS 1u /* its persons are those that are listed; else the model's */
#define TROLLEY_PARTY_MASS 2u
#define TROLLEY_PARTY_UNKNOWN 4u
#define TROLLEY_PARTY_CRUSH 8u

/* trolley_person.seat */
#define TROLLEY_ON_FOOT 0u
#define TROLLEY_FRONT_LEFT 1u
#define TROLLEY_FRONT_RIGHT 2u
#define TROLLEY_REAR_LEFT 3u
#define TROLLEY_REAR_MIDDLE 4u
#define TROLLEY_REAR_RIGHT 5u
#define TROLLEY_RIDER 6u
#define TROLLEY_PILLION 7u

/* trolley_place.flags */
#define TROLLEY_TOUCHES 1u
#define TROLLEY_CERTAIN 2u     /* it certainly comes before the next */
#define TROLLEY_TIED 4u        /* the model cannot distinguish it from the first */
#define TROLLEY_UNEVALUABLE 8u /* no figures */
#define TROLLEY_MISSING 16u    /* the contact is not fully known */
#define TROLLEY_NEAR_MISS 32u
#define TROLLEY_PERSON 64u     /* the worst-off person's figures count */

/* Where a body is and how it moves. */
typedef struct trolley_motion {
  double position_m[3];   /* of the body frame's origin, in the world */
  double angles_deg[3];   /* yaw, pitch, roll, in the order Z, Y, X */
  double velocity_m_s[2]; /* in the ground plane of the world */
} trolley_motion;

/* A collision that may be chosen. */
typedef struct trolley_candidate {
  uint32_t party; /* the opposing party's number */
  uint32_t spare; /* 0 */
  double probability;
  trolley_motion ego;
  trolley_motion other;
} trolley_candidate;

/* A physical body that may be hit; once, however many candidates name it. */
typedef struct trolley_party {
  uint32_t model; /* id in the deployment file */
  uint32_t flags;
  double mass_kg;
  double responsibility; /* 0 to 1 */
  double crush[2];       /* stiffness A (N/m) and B (N/m^2) */
} trolley_party;

typedef struct trolley_person {
  uint32_t party;
  uint32_t seat;
} trolley_person;

typedef struct trolley_request {
  uint32_t version; /* TROLLEY_VERSION */
  uint32_t candidate_count;
  uint32_t party_count;
  uint32_t person_count;
  uint64_t sequence;     /* set by the library */
  uint64_t answer_by_ns; /* set by the library */
  uint32_t flags;
  uint32_t ego; /* number of the party that is the automated vehicle */
  trolley_party parties[TROLLEY_PARTIES_MAX];
  trolley_person persons[TROLLEY_PERSONS_MAX];
  trolley_candidate candidates[TROLLEY_CANDIDATES_MAX];
} trolley_request;

/* One candidate of the ranking. Pairs are the ends of an interval. */
typedef struct trolley_place {
  uint32_t candidate; /* its number in the request */
  uint32_t flags;
  double work[2];  /* the policy's leading measure, as far as the work is done */
  double range[2]; /* the measure over the uncertainty of the model */
  double depth_m[2];
  double ego_delta_v_m_s[2];
  double other_delta_v_m_s[2];
  uint32_t worst_party;
  uint32_t worst_seat;
  double worst[2]; /* probability of injury of the person worst off */
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
  char text[176]; /* UTF-8, ended by zeros */
  trolley_place places[TROLLEY_CANDIDATES_MAX]; /* least harm first */
} trolley_answer;

TROLLEY_ASSERT(sizeof(trolley_motion) == 64);
TROLLEY_ASSERT(sizeof(trolley_candidate) == 144);
TROLLEY_ASSERT(sizeof(trolley_party) == 40);
TROLLEY_ASSERT(sizeof(trolley_request) == 3536);
TROLLEY_ASSERT(offsetof(trolley_request, parties) == 40);
TROLLEY_ASSERT(offsetof(trolley_request, persons) == 720);
TROLLEY_ASSERT(offsetof(trolley_request, candidates) == 1232);
TROLLEY_ASSERT(sizeof(trolley_place) == 112);
TROLLEY_ASSERT(sizeof(trolley_answer) == 2016);
TROLLEY_ASSERT(offsetof(trolley_answer, text) == 48);
TROLLEY_ASSERT(offsetof(trolley_answer, places) == 224);

typedef struct trolley_client trolley_client;

/* Connects to the service of this instance in this folder (NULL if its deployment file names none). nap_ns: how long to sleep between two polls for an answer; 0: poll continuously.
 * Returns NULL on failure, and then writes why into error, which may be NULL. */
trolley_client *trolley_connect(const char *folder, const char *instance, uint64_t nap_ns,
                                char *error, size_t error_length);

/* Sends a request, and waits at most patience_ns for the answer. There is always an answer: if the
 * service gives none, a refusal made by this library. One thread at a time. */
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

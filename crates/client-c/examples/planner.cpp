// A planner in C++: asks what config/scenarios/minimal.toml asks, and prints the ranking.
//
//   trolley serve config/deployments/minimal.toml
//   g++ -std=c++17 -I crates/client-c/include crates/client-c/examples/planner.cpp
//       -L target/release -ltrolley_client -o planner
//   LD_LIBRARY_PATH=target/release ./planner [INSTANCE [FOLDER]]
#include "trolley.h"

#include <cstdio>

int main(int count, char **words) {
  const char *instance = count > 1 ? words[1] : "minimal";
  const char *folder = count > 2 ? words[2] : nullptr;
  char error[256] = "";
  trolley_client *client = trolley_connect(folder, instance, 0, error, sizeof error);
  if (client == nullptr) {
    std::fprintf(stderr, "error: %s\n", error);
    return 75;
  }

  trolley_request request{};
  request.version = TROLLEY_VERSION;
  // Ids of config/deployments/minimal.toml: 1 a sedan, 2 a wall, 3 a pole.
  request.party_count = 3;
  request.parties[0].model = 1;
  request.parties[1].model = 3;
  request.parties[2].model = 2;
  request.ego = 0;

  const char *names[] = {"wall, frontal", "pole, narrow"};
  request.candidate_count = 2;
  trolley_candidate &wall = request.candidates[0];
  wall.party = 2;
  wall.probability = 1.0;
  wall.ego.velocity_m_s[0] = 10.0;
  wall.other.position_m[0] = 2.55;
  wall.other.angles_deg[0] = 90.0;
  trolley_candidate &pole = request.candidates[1];
  pole.party = 1;
  pole.probability = 1.0;
  pole.ego.velocity_m_s[0] = 10.0;
  pole.other.position_m[0] = 2.4;
  pole.other.position_m[1] = 0.3;

  trolley_answer answer;
  trolley_ask(client, &request, 1000000000u, &answer);
  trolley_disconnect(client);
  std::fprintf(stderr, "%s %s\n", trolley_verdict_name(answer.verdict), answer.text);
  for (uint32_t i = 0; i < answer.place_count; i++) {
    const trolley_place &place = answer.places[i];
    std::printf("%u %s %.17g %.17g\n", i + 1, names[place.candidate], place.work[0],
                place.work[1]);
  }
  return answer.verdict <= TROLLEY_CERTIFIED ? 0 : 4;
}

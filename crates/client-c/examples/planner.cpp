// A planner in C++: asks what config/scenarios/wall-or-pole.toml asks, and prints the ranking.
//
//   trolley serve config/deployments/minimal.toml
//   g++ -std=c++17 -I crates/client-c/include crates/client-c/examples/planner.cpp
//       -L target/release -ltrolley_client -o planner
//   LD_LIBRARY_PATH=target/release ./planner [INSTANCE [FOLDER [MEMBERS]]]
//
// An empty FOLDER is the default one. With MEMBERS it is ranked over draws of what is known only up
// to errors.
#include "trolley.h"

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

static trolley_state at(double t_s, double x, double y, double yaw_deg) {
  return {t_s, {x, y, 0.0}, {yaw_deg, 0.0, 0.0}, {0.0, 0.0}, 0};
}

int main(int count, char **words) {
  const char *instance = count > 1 ? words[1] : "minimal";
  const char *folder = count > 2 ? words[2] : nullptr;
  const auto members = static_cast<uint32_t>(count > 3 ? std::atoi(words[3]) : 1);
  char error[256] = "";
  trolley_client *client = trolley_connect(folder, instance, 0, error, sizeof error);
  if (client == nullptr) {
    std::fprintf(stderr, "error: %s\n", error);
    return 75;
  }

  auto request = std::make_unique<trolley_request>();
  request->version = TROLLEY_VERSION;
  request->horizon_s = 5.0;
  trolley_set_members(request.get(), members, members);
  // Ids of config/deployments/minimal.toml: 1 a sedan, 2 a wall, 3 a pole.
  request->ego = 0;
  request->party_count = 3;
  request->parties[0].model = 1;
  const struct { uint32_t party, model; trolley_state place; } fixed[] = {
      {1, 3, at(0.0, 20.0, 2.9, 0.0)}, {2, 2, at(0.0, 25.0, 0.0, 90.0)}};
  for (const auto &body : fixed) {
    trolley_party &party = request->parties[body.party];
    party.model = body.model;
    party.first_path = trolley_add_path(request.get(), TROLLEY_PATH_PLACE, &body.place, 1);
    party.path_count = 1;
    request->paths[party.first_path].probability = 1.0;
  }

  // What localisation and tracking say of themselves; of the wall they say nothing.
  trolley_set_place_errors(&request->parties[0], 0.1, 0.5, 0.25);
  trolley_set_yaw_error(&request->parties[0], 1.5);
  trolley_set_speed_error(&request->parties[0], 0.08);
  trolley_set_place_errors(&request->parties[1], 0.4, 0.6, 0.0);

  const char *names[] = {"straight on, the wall", "to the left, the pole", "brake"};
  trolley_state now = at(0.0, 0.0, 0.0, 0.0);
  now.velocity_m_s[0] = 14.0;
  now.flags = TROLLEY_STATE_VELOCITY;
  const std::vector<trolley_state> left = {at(0.0, 0.0, 0.0, 0.0), at(0.5, 7.0, 0.4, 6.0),
                                           at(1.0, 13.8, 1.8, 14.0), at(1.5, 20.4, 4.0, 20.0)};
  const std::vector<trolley_state> brake = {
      at(0.0, 0.0, 0.0, 0.0),  at(0.5, 6.3, 0.0, 0.0),  at(1.0, 11.2, 0.0, 0.0),
      at(1.5, 14.7, 0.0, 0.0), at(2.0, 16.8, 0.0, 0.0), at(2.5, 17.5, 0.0, 0.0),
      at(2.6, 17.5, 0.0, 0.0)};
  request->candidate_count = 3;
  request->candidates[0].path = trolley_add_path(request.get(), TROLLEY_PATH_ONWARD, &now, 1);
  for (const auto *states : {&left, &brake}) {
    const auto count = static_cast<uint32_t>(states->size());
    const uint32_t number = states == &left ? 1 : 2;
    request->candidates[number].path =
        trolley_add_path(request.get(), TROLLEY_PATH_STATES, states->data(), count);
  }

  trolley_answer answer;
  trolley_ask(client, request.get(), 1000000000u, &answer);
  trolley_disconnect(client);
  std::fprintf(stderr, "%s %s\n", trolley_verdict_name(answer.verdict), answer.text);
  for (uint32_t i = 0; i < answer.place_count; i++) {
    const trolley_place &place = answer.places[i];
    std::printf("%u %s: %.17g %.17g", i + 1, names[place.candidate], place.work[0],
                place.work[1]);
    if (const trolley_expected *of = trolley_expected_of(&place)) {
      const double figures[] = {of->contact,      of->injured[0],   of->injured[1],   of->error,
                                of->quantiles[0], of->quantiles[1], of->quantiles[2], of->best,
                                of->regret,       of->worlds};
      for (double figure : figures) std::printf(" %.17g", figure);
      for (uint32_t k = 0; k < trolley_met_listed(of); k++) {
        const trolley_met &met = of->meets[k];
        std::printf(" %u %.17g %.17g", met.party, met.probability, met.from_s);
      }
    }
    std::printf("\n");
  }
  if ((answer.flags & TROLLEY_LEAD) != 0) {
    std::printf("%u members: %.17g %.17g\n", answer.members, answer.lead, answer.lead_error);
  }
  return answer.verdict <= TROLLEY_CERTIFIED ? 0 : 4;
}

// What the drivers for first contact share: the motions of a case, and the result line.
//
//     DRIVER CASE [--seconds S]
//
// CASE is a folder with a.stl, b.stl and sweeps.txt: a line per motion, with its name, R (9 numbers)
// and t (3) of B in A's frame at travel 0, the direction of B there (3, of length 1), and the
// travels from where to where (m). The answer is a line of JSON per motion: the travel at first
// contact, or null for never, and the median time of a query (ms). Trees are built before. A solver
// begins no motion after S seconds.
#pragma once

#include "case.hpp"

#include <cmath>
#include <sstream>

namespace peers {

struct Motion {
    std::string name;
    Pose pose;
    Point direction;
    double from, to;

    Point at(double travel) const {
        return {direction.x * travel, direction.y * travel, direction.z * travel};
    }
};

inline std::vector<Motion> read_motions(const std::string& path) {
    std::ifstream file(path);
    std::vector<Motion> motions;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        Motion m;
        words >> m.name;
        for (auto& row : m.pose.rotation) {
            for (double& x : row) words >> x;
        }
        for (double& x : m.pose.translation) words >> x;
        words >> m.direction.x >> m.direction.y >> m.direction.z >> m.from >> m.to;
        if (!words) throw std::runtime_error(path + ": not a motion: " + line);
        motions.push_back(m);
    }
    if (motions.empty()) throw std::runtime_error(path + ": no motions");
    return motions;
}

// `never` where `travel` is not a number.
inline void print_contact(const char* peer, const Motion& m, double travel, double query_ms) {
    char number[32] = "null";
    if (std::isfinite(travel)) std::snprintf(number, sizeof number, "%.17g", travel);
    std::printf("{\"peer\":\"%s\",\"name\":\"%s\",\"first_contact_m\":%s,\"query_ms\":%.6f}\n", peer,
                m.name.c_str(), number, query_ms);
    std::fflush(stdout);
}

}  // namespace peers

// What all drivers share: the case, the clock, the result line. A driver is one library behind
//
//     DRIVER CASE [--repeat N] [--threads N] [--cold] [--moving]
//
// CASE is a folder with a.stl and b.stl (binary STL) and pose.txt: the world poses of A and then B,
// each 3 lines of 4 numbers (R | t), row-major. Everybody works in A's frame: R = Ra^T Rb,
// t = Ra^T (tb - ta), and a vertex of B is ((R0 x + R1 y) + R2 z) + t, in doubles, sums left to
// right, never fused (hence -ffp-contract=off). That defines the input; what a library makes of it
// is its own affair.
//
// The answer is one line of JSON. All times are in milliseconds: of both trees (build_ms), of what
// a new pose costs before it can be queried (pose_ms), and of a query (query_ms): medians. With
// --moving B is posed anew for each query, some millimetres elsewhere, for a processor learns the
// branches of a query that is only repeated; the pairs are always those of the case itself.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace peers {

struct Point {
    double x, y, z;
};

inline Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

using Triangle = std::array<Point, 3>;

// Equal vertices are stored once, as these libraries like it; triangles keep the file's order.
struct Mesh {
    std::vector<Point> points;
    std::vector<std::array<uint32_t, 3>> triangles;

    Triangle operator[](uint32_t i) const {
        const auto& t = triangles[i];
        return {points[t[0]], points[t[1]], points[t[2]]};
    }
};

struct Pose {
    double rotation[3][3];
    double translation[3];

    Point operator()(const Point& p) const {
        auto row = [&](int i) {
            const double* r = rotation[i];
            return ((r[0] * p.x + r[1] * p.y) + r[2] * p.z) + translation[i];
        };
        return {row(0), row(1), row(2)};
    }

    // B seen from A.
    static Pose between(const Pose& a, const Pose& b) {
        double d[3];
        for (int i = 0; i < 3; i++) d[i] = b.translation[i] - a.translation[i];
        auto column = [&](int i, double x, double y, double z) {
            return a.rotation[0][i] * x + a.rotation[1][i] * y + a.rotation[2][i] * z;
        };
        Pose pose;
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                pose.rotation[i][j] =
                    column(i, b.rotation[0][j], b.rotation[1][j], b.rotation[2][j]);
            }
            pose.translation[i] = column(i, d[0], d[1], d[2]);
        }
        return pose;
    }
};

inline Mesh read_stl(const std::string& path) {
    static_assert(sizeof(float) == 4);
    constexpr size_t HEADER = 80, RECORD = 50, NORMAL = 12;
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    uint32_t count = 0;
    if (bytes.size() >= HEADER + 4) std::memcpy(&count, &bytes[HEADER], 4);
    if (!file || bytes.size() != HEADER + 4 + count * RECORD || count == 0) {
        throw std::runtime_error(path + ": not a binary STL with triangles");
    }

    struct Bits {
        uint32_t x, y, z;
        bool operator==(const Bits& o) const { return x == o.x && y == o.y && z == o.z; }
    };
    struct Hash {
        size_t operator()(const Bits& b) const {
            uint64_t h = b.x * 0x9E3779B97F4A7C15u ^ b.y * 0xC2B2AE3D27D4EB4Fu;
            h = (h ^ b.z) * 0xD6E8FEB86659FD93u;
            return h ^ (h >> 32);
        }
    };
    std::unordered_map<Bits, uint32_t, Hash> known;
    known.reserve(count);
    Mesh mesh;
    mesh.triangles.resize(count);
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            float c[3];
            std::memcpy(c, &bytes[HEADER + 4 + i * RECORD + NORMAL + k * sizeof c], sizeof c);
            for (float& x : c) x += 0.0f;  // the two zeros are one point
            Bits bits;
            std::memcpy(&bits, c, sizeof bits);
            auto [at, is_new] = known.emplace(bits, uint32_t(mesh.points.size()));
            if (is_new) mesh.points.push_back({c[0], c[1], c[2]});
            mesh.triangles[i][k] = at->second;
        }
    }
    return mesh;
}

struct Case {
    std::string name;
    Mesh a, b;
    Pose worlds[2];  // of A, of B

    explicit Case(std::string folder) {
        while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
        name = folder.substr(folder.find_last_of('/') + 1);
        a = read_stl(folder + "/a.stl");
        b = read_stl(folder + "/b.stl");
        std::ifstream file(folder + "/pose.txt");
        for (Pose& world : worlds) {
            for (int i = 0; i < 3; i++) {
                for (double& x : world.rotation[i]) file >> x;
                file >> world.translation[i];
            }
        }
        if (!file) throw std::runtime_error(folder + "/pose.txt: not 24 numbers");
    }

    // B seen from A, with B so far along the world's x from where the case has it.
    Pose pose(double metres = 0) const {
        Pose moved = worlds[1];
        moved.translation[0] += metres;
        return Pose::between(worlds[0], moved);
    }

    // B's vertices in A's frame, likewise.
    std::vector<Point> placed_b(double metres = 0) const {
        std::vector<Point> placed(b.points.size());
        std::transform(b.points.begin(), b.points.end(), placed.begin(), pose(metres));
        return placed;
    }
};

struct Options {
    std::string folder;
    int repeat = 9;
    int threads = 1;
    bool cold = false;
    bool moving = false;

    Options(int count, char** words) {
        auto number = [&](int& i) {
            int n = ++i < count ? std::atoi(words[i]) : 0;
            return n > 0 ? n : throw std::runtime_error("a count of at least 1 is missing");
        };
        for (int i = 1; i < count; i++) {
            std::string word = words[i];
            if (word == "--repeat") repeat = number(i);
            else if (word == "--threads") threads = number(i);
            else if (word == "--cold") cold = true;
            else if (word == "--moving") moving = true;
            else folder = word;
        }
        if (folder.empty()) throw std::runtime_error("no case given");
    }
};

inline double now_ms() {
    auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double, std::milli>(now).count();
}

inline double median(std::vector<double> times) {
    if (times.empty()) return 0;
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// Pushes everything else out of the caches, by writing to 64 MiB.
inline void flush_caches() {
    static std::vector<uint64_t> large((64 << 20) / sizeof(uint64_t));
    for (size_t i = 0; i < large.size(); i += 8) large[i]++;
    asm volatile("" : : "r"(large.data()) : "memory");  // as if somebody read it
}

struct Times {
    double pose_ms, query_ms;
};

// Poses B by `place(metres)`, runs `query` once to warm up and then `repeat` times; the medians.
// A moving body stands up to 4 mm from the pose of the case, elsewhere each time, and at last there.
template <class Place, class Query>
Times measure(const Options& options, Place place, Query query) {
    constexpr int POSINGS = 3;  // of a body that does not move
    std::vector<double> posings, queries;
    auto time = [](std::vector<double>& times, auto&& work) {
        double start = now_ms();
        work();
        times.push_back(now_ms() - start);
    };
    for (int i = 0; i < (options.moving ? 1 : POSINGS); i++) time(posings, [&] { place(0.0); });
    query();
    for (int turn = options.repeat; turn-- > 0;) {
        if (options.moving) time(posings, [&] { place(.001 * ((turn + 4) % 9 - 4)); });
        if (options.cold) flush_caches();
        time(queries, query);
    }
    return {median(posings), median(queries)};
}

using Pair = std::pair<uint32_t, uint32_t>;  // triangle of A, triangle of B

inline uint64_t splitmix64(uint64_t x) {
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

// A sum modulo 2^64 does not know in which order its terms came.
inline uint64_t hash(const std::vector<Pair>& pairs) {
    uint64_t sum = 0;
    for (auto [a, b] : pairs) sum += splitmix64(uint64_t(a) << 32 | b);
    return sum;
}

struct Result {
    const char* peer;
    double build_ms = 0;
    Times times = {};
    std::vector<Pair> pairs = {};
    uint64_t np = 0;        // triangle pairs tested, 0 if unknown
    std::string more = {};  // further fields, each with a comma before it
};

inline void print(const Case& c, const Result& r) {
    std::printf(
        "{\"peer\":\"%s\",\"case\":\"%s\",\"build_ms\":%.4f,\"pose_ms\":%.4f,\"query_ms\":%.4f,"
        "\"pairs\":%zu,\"hash\":\"%016llx\",\"nb\":0,\"np\":%llu%s}\n",
        r.peer, c.name.c_str(), r.build_ms, r.times.pose_ms, r.times.query_ms, r.pairs.size(),
        (unsigned long long)hash(r.pairs), (unsigned long long)r.np, r.more.c_str());
}

// The driver itself: what it throws becomes a message and exit code 1.
template <class Driver>
int run(int count, char** words, Driver driver) {
    try {
        Options options(count, words);
        Case c(options.folder);
        print(c, driver(c, options));
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", words[0], e.what());
        return 1;
    }
}

}  // namespace peers

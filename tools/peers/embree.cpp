// Embree 3: rtcCollide over two scenes of user geometry, with the triangle test in its callback.
//
// rtcCollide knows no instances, so a new pose means B's boxes anew and a rebuild of its scene:
// that, with the end of the former one, is pose_ms. The boxes are rounded outward to floats:
// Embree's walk loses no pair.
#include "triangle.hpp"

#include <embree3/rtcore.h>

#include <atomic>
#include <limits>
#include <optional>

namespace {

using namespace peers;

struct Body {
    const Mesh& mesh;
    std::vector<Point> points;  // in A's frame

    Triangle operator[](uint32_t i) const {
        const auto& t = mesh.triangles[i];
        return {points[t[0]], points[t[1]], points[t[2]]};
    }
};

float below(double x) {
    float rounded = float(x);
    return rounded <= x ? rounded : std::nextafter(rounded, -std::numeric_limits<float>::max());
}

float above(double x) {
    float rounded = float(x);
    return rounded >= x ? rounded : std::nextafter(rounded, std::numeric_limits<float>::max());
}

void bounds(const RTCBoundsFunctionArguments* arguments) {
    const Body& body = *static_cast<const Body*>(arguments->geometryUserPtr);
    auto [a, b, c] = body[arguments->primID];
    RTCBounds& box = *arguments->bounds_o;
    box.lower_x = below(std::min({a.x, b.x, c.x}));
    box.lower_y = below(std::min({a.y, b.y, c.y}));
    box.lower_z = below(std::min({a.z, b.z, c.z}));
    box.upper_x = above(std::max({a.x, b.x, c.x}));
    box.upper_y = above(std::max({a.y, b.y, c.y}));
    box.upper_z = above(std::max({a.z, b.z, c.z}));
}

// What one of Embree's threads found.
struct Found {
    std::vector<Pair> pairs;
    uint64_t np = 0;
};

struct Query {
    const Body &a, &b;
    std::vector<Found> by_thread;
    std::atomic<size_t> threads{0};
};

void collide(void* user, RTCCollision* candidates, unsigned count) {
    Query& query = *static_cast<Query*>(user);
    static thread_local size_t own = query.threads++;  // there is one query per process
    Found& found = query.by_thread.at(own);
    found.np += count;
    for (unsigned i = 0; i < count; i++) {
        Pair pair{candidates[i].primID0, candidates[i].primID1};
        if (meet(query.a[pair.first], query.b[pair.second])) found.pairs.push_back(pair);
    }
}

class Scene {
    RTCScene scene;

public:
    Scene(RTCDevice device, Body& body) : scene(rtcNewScene(device)) {
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(body.mesh.triangles.size()));
        rtcSetGeometryUserData(geometry, &body);
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        // Embree wants functions for rays, which nobody will shoot.
        rtcSetGeometryIntersectFunction(geometry, [](const RTCIntersectFunctionNArguments*) {});
        rtcSetGeometryOccludedFunction(geometry, [](const RTCOccludedFunctionNArguments*) {});
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, 0);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
    }
    Scene(const Scene&) = delete;
    ~Scene() { rtcReleaseScene(scene); }

    operator RTCScene() const { return scene; }
};

Result drive(const Case& c, const Options& options) {
    std::string config = "set_affinity=0,threads=" + std::to_string(options.threads);
    RTCDevice device = rtcNewDevice(config.c_str());
    Body a{c.a, c.a.points}, b{c.b, c.b.points};
    Result result{"embree"};

    double start = now_ms();
    Scene scene_a(device, a);
    { Scene unposed_b(device, b); }
    result.build_ms = now_ms() - start;

    std::optional<Scene> scene_b;
    auto place = [&](double metres) {
        scene_b.reset();
        b.points = c.placed_b(metres);
        scene_b.emplace(device, b);
    };
    // The thread that asks may take part.
    Query query{a, b, std::vector<Found>(options.threads + 1)};
    auto ask = [&] {
        for (Found& found : query.by_thread) found.pairs.clear(), found.np = 0;
        rtcCollide(scene_a, *scene_b, collide, &query);
    };
    result.times = measure(options, place, ask);
    for (const Found& found : query.by_thread) {
        result.pairs.insert(result.pairs.end(), found.pairs.begin(), found.pairs.end());
        result.np += found.np;
    }
    if (RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
        throw std::runtime_error("Embree reports error " + std::to_string(error));
    }
    return result;
}

}  // namespace

int main(int count, char** words) { return peers::run(count, words, drive); }

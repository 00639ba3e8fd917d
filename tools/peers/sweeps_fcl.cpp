// FCL 0.7, continuous collision of two models: three of its solvers, each as it comes but for the
// number of iterations. B's vertices are put into A's frame first, as the polynomial solver knows no
// rotation; that solver changes its models, so it gets new ones each time, which is not timed. On the
// cars of 10,000 triangles, conservative advancement finds no contact either with trees of RSS, with
// a motion of the kind CCDM_LINEAR, or if B is the first body.
#include "sweeps.hpp"

#include <fcl/fcl.h>

namespace {

using namespace peers;
using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> model_of(const Mesh& mesh, const Pose* pose) {
    std::vector<fcl::Vector3d> points;
    std::vector<fcl::Triangle> triangles;
    for (const Point& stored : mesh.points) {
        Point p = pose ? (*pose)(stored) : stored;
        points.emplace_back(p.x, p.y, p.z);
    }
    for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<Model>();
    model->beginModel(int(triangles.size()), int(points.size()));
    model->addSubModel(points, triangles);
    model->endModel();
    return model;
}

fcl::Transform3d moved(const Motion& m, double travel) {
    fcl::Transform3d transform = fcl::Transform3d::Identity();
    Point p = m.at(travel);
    transform.translation() = fcl::Vector3d(p.x, p.y, p.z);
    return transform;
}

struct Solver {
    const char* name;
    fcl::CCDSolverType type;
    bool changes_models;
};

constexpr Solver SOLVERS[] = {
    {"fcl, conservative advancement", fcl::CCDC_CONSERVATIVE_ADVANCEMENT, false},
    {"fcl, polynomial", fcl::CCDC_POLYNOMIAL_SOLVER, true},
    {"fcl, naive", fcl::CCDC_NAIVE, false},
};

// Contact of a motion by a solver: its travel, and the median time.
void solve(const Solver& solver, const Mesh& a, const Mesh& b, const Motion& m) {
    constexpr int RUNS = 5;
    constexpr double ENOUGH_MS = 300;
    constexpr size_t ITERATIONS = 1000;
    fcl::ContinuousCollisionRequestd request(ITERATIONS);
    request.ccd_solver_type = solver.type;
    fcl::ContinuousCollisionResultd result;
    std::vector<double> times;
    double total = 0;
    auto model_a = model_of(a, nullptr), model_b = model_of(b, &m.pose);
    for (int run = 0; run < RUNS && total < ENOUGH_MS; run++) {
        if (run > 0 && solver.changes_models) {
            model_a = model_of(a, nullptr);
            model_b = model_of(b, &m.pose);
        }
        const auto rest = fcl::Transform3d::Identity();
        result = {};
        double start = now_ms();
        fcl::continuousCollide(model_a.get(), rest, rest, model_b.get(), moved(m, m.from),
                               moved(m, m.to), request, result);
        times.push_back(now_ms() - start);
        total += times.back();
    }
    double travel = m.from + result.time_of_contact * (m.to - m.from);
    print_contact(solver.name, m, result.is_collide ? travel : NAN, median(times));
}

}  // namespace

int main(int count, char** words) {
    try {
        std::string folder = count > 1 ? words[1] : "";
        double limit_ms = count > 3 ? 1000 * std::atof(words[3]) : INFINITY;
        Mesh a = read_stl(folder + "/a.stl"), b = read_stl(folder + "/b.stl");
        auto motions = read_motions(folder + "/sweeps.txt");
        for (const Solver& solver : SOLVERS) {
            double start = now_ms();
            for (const Motion& m : motions) {
                if (now_ms() - start < limit_ms) solve(solver, a, b, m);
            }
        }
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", words[0], e.what());
        return 1;
    }
}

// FCL 0.7: two models with trees of oriented boxes, all contacts. It has its own triangle test, in
// doubles with tolerances of its own, and takes the pose as it is: a new one costs nothing.
#include "case.hpp"

#include <fcl/fcl.h>

namespace {

using namespace peers;
using Model = fcl::BVHModel<fcl::OBBd>;

std::shared_ptr<Model> model_of(const Mesh& mesh) {
    std::vector<fcl::Vector3d> points;
    std::vector<fcl::Triangle> triangles;
    for (const Point& p : mesh.points) points.emplace_back(p.x, p.y, p.z);
    for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto model = std::make_shared<Model>();
    model->beginModel(int(triangles.size()), int(points.size()));
    model->addSubModel(points, triangles);
    model->endModel();
    return model;
}

fcl::Transform3d transform_of(const Pose& pose) {
    fcl::Transform3d transform = fcl::Transform3d::Identity();
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) transform(i, j) = pose.rotation[i][j];
        transform(i, 3) = pose.translation[i];
    }
    return transform;
}

Result drive(const Case& c, const Options& options) {
    Result result{"fcl"};
    double start = now_ms();
    auto a = model_of(c.a), b = model_of(c.b);
    result.build_ms = now_ms() - start;

    const fcl::CollisionRequestd request(std::numeric_limits<int>::max(), false);
    const auto at_rest = fcl::Transform3d::Identity();
    fcl::Transform3d placed;
    fcl::CollisionResultd found;
    auto place = [&](double metres) { placed = transform_of(c.pose(metres)); };
    auto ask = [&] {
        found.clear();
        fcl::collide(a.get(), at_rest, b.get(), placed, request, found);
    };
    result.times = measure(options, place, ask);
    for (size_t i = 0; i < found.numContacts(); i++) {
        const auto& contact = found.getContact(i);
        result.pairs.emplace_back(contact.b1, contact.b2);
    }
    return result;
}

}  // namespace

int main(int count, char** words) { return peers::run(count, words, drive); }

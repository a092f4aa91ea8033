#include "master/station/display.h"

#include "master/station/moment_json.h"

namespace palpate {

void Display::PutImage(const std::string& jpeg, double t) {
  board_->Put(Topic::kImage, Framed({static_cast<std::uint32_t>(Topic::kImage), 0, t}, jpeg));
}

void Display::PutShape(const RemoteMesh& mesh, double t) {
  const auto put = [&](Topic topic, double at, const std::string& bytes) {
    board_->Put(topic, Framed({static_cast<std::uint32_t>(topic), topology_number_, at}, bytes));
  };
  if (mesh.topology != topology_) {
    topology_ = mesh.topology;
    ++topology_number_;
    put(Topic::kTopology, 0, TopologyBytes(*topology_));
    if (!topology_->field_rest.empty()) {
      put(Topic::kFieldTopology, 0, FieldTopologyBytes(*topology_));
    }
  }
  put(Topic::kShape, t, ShapeBytes(mesh));
  if (!mesh.displacement.empty()) put(Topic::kField, t, FieldBytes(mesh));
}

}  // namespace palpate

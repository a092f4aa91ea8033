#include "master/station/display.h"

#include "master/station/moment_json.h"

namespace palpate {

void Display::PutImage(const std::string& jpeg, double t) {
  board_->Put(Topic::kImage, Framed({static_cast<std::uint32_t>(Topic::kImage), 0, t}, jpeg));
}

void Display::PutShape(const RemoteMesh& mesh, double t) {
  if (mesh.topology != topology_) {
    topology_ = mesh.topology;
    board_->Put(Topic::kTopology,
                Framed({static_cast<std::uint32_t>(Topic::kTopology), ++topology_number_, 0},
                       TopologyBytes(*topology_)));
  }
  board_->Put(
      Topic::kShape,
      Framed({static_cast<std::uint32_t>(Topic::kShape), topology_number_, t}, ShapeBytes(mesh)));
}

}  // namespace palpate

// Puts images and shapes on the notice board.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/remote_mesh.h"
#include "master/station/server/notice_board.h"

namespace palpate {

// A Display is not thread-safe.
class Display {
 public:
  // `board` must outlive this object.
  explicit Display(NoticeBoard* board) : board_(board) {}

  // `t`: sample time since the start of the run [s].
  void PutImage(const std::string& jpeg, double t);
  // Puts a shape. A changed topology is put before it.
  void PutShape(const RemoteMesh& mesh, double t);

 private:
  NoticeBoard* board_;
  std::shared_ptr<const MeshTopology> topology_;
  std::uint32_t topology_number_ = 0;
};

}  // namespace palpate

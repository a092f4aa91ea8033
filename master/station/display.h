// Pictures and shapes on their way to the board.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/remote_mesh.h"
#include "master/station/notice_board.h"

namespace palpate {

// One thread.
class Display {
 public:
  // `board` outlives it.
  explicit Display(NoticeBoard* board) : board_(board) {}

  // `t`: when it was sensed [s] since the run began.
  void PutPicture(const std::string& jpeg, double t);
  // What it is the shape of goes before it, when that is another one.
  void PutShape(const RemoteMesh& mesh, double t);

 private:
  NoticeBoard* board_;
  std::shared_ptr<const MeshTopology> topology_;
  std::uint32_t topology_number_ = 0;
};

}  // namespace palpate

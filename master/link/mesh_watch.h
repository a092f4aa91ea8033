// Receives the newest mesh of the object's surface, on a separate channel and thread. While it
// exists, the slave computes a full displacement field for it, so make one only if it is shown.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "master/link/remote_mesh.h"
#include "master/link/slave_link.h"

namespace palpate {

class MeshWatch {
 public:
  struct Options {
    double rate = 5;            // largest rate of meshes [Hz], 1 to 120
    bool nodal_forces = false;  // request nodal forces
    double relative_error =
        0;                  // of a coordinate, relative to the object's diagonal [-]; 0: all digits
    bool traction = false;  // request the traction
  };
  struct Stats {
    std::uint64_t meshes = 0, refused = 0;  // received; rejected as invalid
    double deflection_peak = 0;             // largest deflection so far [m]
    std::string trouble;                    // why no mesh arrives, or why the last was rejected
  };

  // Opens the stream and keeps it open, reconnecting with back-off. Throws
  // std::invalid_argument for an invalid target, or one beyond loopback without `insecure`.
  MeshWatch(const SlaveLink::Options& link, const Options& options);
  ~MeshWatch();

  // Null: none received yet. Thread-safe.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> newest() const;
  [[nodiscard]] Stats stats() const;  // thread-safe
  // Ends the stream. The last mesh stays.
  void Stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate

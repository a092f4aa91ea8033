// Watches the object's surface beside the force: a channel and a thread of its own, the newest mesh
// only. While it lives the slave computes a full displacement field for it: make one only where
// somebody looks.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "master/link/remote_mesh.h"

namespace palpate {

class MeshWatch {
 public:
  struct Options {
    std::string target;         // HOST:PORT
    bool insecure = false;      // allow targets that are not loopback, in plain text
    std::filesystem::path tls;  // the folder of our certificate; empty: plain text
    double rate = 5;            // at most so many meshes a second [Hz], 1 to 120
    bool nodal_forces = false;  // ask for them too
    std::chrono::milliseconds longest_round_trip{1000};  // beyond it the line is dead
    double relative_error = 0;  // of a coordinate, of the object's diagonal [-]; 0: all digits
    bool traction = false;      // ask for it too
  };
  struct Stats {
    std::uint64_t meshes = 0, refused = 0;  // taken; with impossible numbers
    double deflection_peak = 0;             // largest deflection seen [m]
    std::string trouble;  // why no mesh comes at the moment, or why the last was refused
  };

  // Opens the stream and keeps it open, reconnecting with back-off. Throws std::invalid_argument:
  // target not understood, or not loopback without `insecure`.
  explicit MeshWatch(const Options& options);
  ~MeshWatch();

  // Null: none came yet. Thread-safe.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> newest() const;
  [[nodiscard]] Stats stats() const;  // thread-safe
  // No more meshes; the last one stays.
  void Stop();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate

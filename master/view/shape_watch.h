// Receives the object's shape during a session, if it is shown or written to files.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "master/link/observer.h"
#include "master/session/session.h"

namespace palpate {

// The deformed object and the forces of the fingertips at one moment.
struct ShapeMoment {
  std::shared_ptr<const RemoteMesh> mesh;  // null: none
  std::vector<NamedFinger> fingers;
};

// Checks the name of a shape file. Throws std::invalid_argument unless it ends in .vtu (a mesh for
// ParaView).
void CheckShapeFile(const std::filesystem::path& file);

// Writes the whole file or nothing: an unstructured grid of the deformed surface with
// `displacement` and, if known, `nodal_force`. Each finger is a vertex with `finger_force`. False:
// it cannot be written.
bool WriteShape(const ShapeMoment& moment, const std::filesystem::path& file);

// File of the largest deflection: `pinch.vtu` -> `pinch-deepest.vtu`.
std::filesystem::path DeepestFile(const std::filesystem::path& file);

class ShapeFile {
 public:
  static constexpr std::chrono::milliseconds kPeriod{1000};  // shortest period between two writes

  // `newest` returns the newest mesh, or null. It is called on the writer's thread and must outlive
  // this object. Throws like CheckShapeFile.
  ShapeFile(std::filesystem::path file, std::function<std::shared_ptr<const RemoteMesh>()> newest);
  ~ShapeFile();

  // Sets the present forces of the fingers. Returns at once.
  void Update(std::vector<NamedFinger> fingers);
  // Writes the last moment and the one of the largest deflection, and ends. Returns the reason if a
  // file is missing, else an empty string.
  std::string Finish();

 private:
  void Run();
  void Write();

  const std::filesystem::path file_;
  const std::function<std::shared_ptr<const RemoteMesh>()> newest_;
  bool failed_ = false;  // used by the writer's thread until it ends, like the next one
  ShapeMoment deepest_;  // without a mesh: nothing written yet

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  ShapeMoment moment_;  // without its mesh
  bool stopping_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

class ShapeWatch {
 public:
  // Requests meshes if there are `files`, or if the scene has fingertips and their `table` is
  // shown. Throws like CheckShapeFile. `observer` must outlive this object.
  ShapeWatch(Observer* observer, const RemoteScene& scene,
             const std::vector<std::filesystem::path>& files, bool table);

  // Null: none received, or not requested.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> newest() const;
  void Update(const SessionStatus& status);
  // Ends the stream, writes the files a last time and completes the report. False: a file is
  // missing.
  bool Finish(Report* report);

 private:
  Observer* observer_ = nullptr;  // null: no meshes requested
  std::vector<std::unique_ptr<ShapeFile>> files_;
};

}  // namespace palpate

// What is watched of the object's shape while the hand works: nothing, unless somebody looks.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "master/haptics/session.h"
#include "master/link/mesh_watch.h"
#include "master/view/shape_picture.h"

namespace palpate {

// The newest deformed surface in a file that others look at while it is rewritten: a picture, or a
// mesh for ParaView. Never in the path of the force. Throws std::invalid_argument unless the name
// ends in .svg or .vtu.
void CheckShapeFile(const std::filesystem::path& file);

// The file has room for the forces at the nodes.
bool NeedsNodalForces(const std::filesystem::path& file);

// Writes `moment` whole or not at all: as DrawShape's picture (.svg), or as an unstructured grid
// (.vtu): the deformed surface with `displacement` and, where told, `nodal_force`, each finger a
// vertex with its `finger_force` on the object. False: it cannot be written.
bool WriteShape(const ShapeMoment& moment, const std::filesystem::path& file);

// Where the moment of the largest deflection goes: `pinch.svg` -> `pinch-deepest.svg`.
std::filesystem::path DeepestFile(const std::filesystem::path& file);

class ShapeFile {
 public:
  static constexpr std::chrono::milliseconds kPeriod{1000};  // not more often than this

  // `newest` gives the newest mesh, null: none yet; it is asked by the writer's thread and outlives
  // this. `scene` and `homes` as in ShapeMoment. Throws std::invalid_argument: see CheckShapeFile.
  ShapeFile(std::filesystem::path file, std::string scene, std::vector<Eigen::Vector3d> homes,
            std::function<std::shared_ptr<const RemoteMesh>()> newest);
  ~ShapeFile();

  // What the fingers feel at this moment. Returns at once.
  void Update(double t, std::vector<NamedFinger> fingers);
  // Writes once more, and besides the deepest of the moments written so far, and ends. Empty, or
  // why the files are not there.
  std::string Finish();

 private:
  void Run();
  void Write();

  const std::filesystem::path file_;
  const std::function<std::shared_ptr<const RemoteMesh>()> newest_;
  bool failed_ = false;  // the writer's own until it has ended, as is what follows
  ShapeMoment deepest_;  // without a mesh: nothing was written yet

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  ShapeMoment moment_;  // without its mesh
  bool stopping_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

class ShapeWatch {
 public:
  // Meshes come if there are `files` to keep, or if the scene has fingertips and the `table` of
  // them is seen. Throws std::invalid_argument: see MeshWatch and CheckShapeFile.
  ShapeWatch(const SlaveLink::Options& link, const RemoteScene& scene,
             const std::vector<std::filesystem::path>& files, bool table);

  // Null: none came, or nobody looks.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> newest() const;
  void Update(const Status& status);
  // Ends the watch, writes the files a last time and tells the report. False: a file that was asked
  // for is not there.
  bool Finish(Report* report);

 private:
  std::unique_ptr<MeshWatch> meshes_;              // null: nobody looks
  std::vector<std::unique_ptr<ShapeFile>> files_;  // after what they ask
};

}  // namespace palpate

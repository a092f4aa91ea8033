// What is watched of the object's shape while the hand works: nothing, unless somebody looks.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "master/haptics/record/report.h"
#include "master/haptics/session.h"
#include "master/link/mesh_watch.h"
#include "master/view/shape_file.h"

namespace palpate {

class ShapeWatch {
 public:
  // Meshes come if there are `files` to keep, or if the scene has fingertips and the `table` of
  // them is seen. Throws std::invalid_argument: see MeshWatch and CheckShapeFile.
  ShapeWatch(const SlaveLink::Options& link, const RemoteScene& scene,
             const std::vector<std::filesystem::path>& files, bool table);

  // Null: none came, or nobody looks.
  [[nodiscard]] std::shared_ptr<const RemoteMesh> newest() const;
  void See(const Status& status);
  // Ends the watch, writes the files a last time and tells the report. False: a file that was asked
  // for is not there.
  bool Finish(Report* report);

 private:
  std::unique_ptr<MeshWatch> meshes_;              // null: nobody looks
  std::vector<std::unique_ptr<ShapeFile>> files_;  // after what they ask
};

}  // namespace palpate

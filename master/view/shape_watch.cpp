#include "master/view/shape_watch.h"

#include <algorithm>

namespace palpate {

ShapeWatch::ShapeWatch(const SlaveLink::Options& link, const RemoteScene& scene,
                       const std::vector<std::filesystem::path>& files, bool table) {
  if (files.empty() && !(table && !scene.fingertips.empty())) return;
  MeshWatch::Options options;
  options.target = link.target;
  options.insecure = link.insecure;
  options.nodal_forces = std::any_of(files.begin(), files.end(), NeedsNodalForces);
  meshes_ = std::make_unique<MeshWatch>(options);
  std::vector<Eigen::Vector3d> homes;
  for (const RemoteFingertip& tip : scene.fingertips) homes.push_back(tip.p_S_home);
  for (const auto& file : files) {
    files_.push_back(std::make_unique<ShapeFile>(
        file, scene.name, homes, [meshes = meshes_.get()] { return meshes->newest(); }));
  }
}

std::shared_ptr<const RemoteMesh> ShapeWatch::newest() const {
  return meshes_ ? meshes_->newest() : nullptr;
}

void ShapeWatch::See(const Status& status) {
  for (const auto& file : files_) file->See(status.t, status.fingers);
}

bool ShapeWatch::Finish(Report* report) {
  if (!meshes_) return true;
  meshes_->Stop();
  const MeshWatch::Stats stats = meshes_->stats();
  report->shape = ShapeReport{stats.meshes, stats.deflection_peak};
  bool all_there = true;
  for (const auto& file : files_) {
    const std::string trouble = file->Finish();
    if (trouble.empty()) continue;
    all_there = false;
    report->trouble.push_back(trouble);
    if (!stats.trouble.empty()) report->trouble.push_back(stats.trouble);
  }
  return all_there;
}

}  // namespace palpate

#include "master/view/shape_watch.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "shared/mesh/vtu_writer.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// The known force of the finger on the object, S [N]; zero: unknown.
Eigen::Vector3d PressOf(const FingerState& finger) {
  const bool known = finger.in_contact && IsForceKnown(finger);
  return known ? Eigen::Vector3d(-finger.force->cast<double>()) : Eigen::Vector3d(0, 0, 0);
}

// Present position of the contact point of `finger`, S [m]: it moves with the surface. For a free
// finger it is the position of the finger.
Eigen::Vector3d PlaceNow(const FingerState& finger, const RemoteMesh& mesh) {
  const Eigen::Vector3d place = finger.p_S_contact.cast<double>();
  const SurfaceMesh& rest = mesh.topology->surface;
  if (!finger.in_contact || rest.triangles.empty()) return place;
  const auto found = FindPlace(rest, place);
  if (!found || found->triangle < 0) return place;
  Eigen::Vector3d moved(0, 0, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto node =
        static_cast<std::size_t>(rest.triangles[static_cast<std::size_t>(found->triangle)][i]);
    moved +=
        found->weights[static_cast<Eigen::Index>(i)] * (mesh.positions[node] - rest.nodes[node]);
  }
  return place + moved;
}

void Append(const std::vector<Eigen::Vector3d>& vectors, PointArray* array) {
  for (const Eigen::Vector3d& v : vectors) {
    array->values.insert(array->values.end(), {v.x(), v.y(), v.z()});
  }
}

VtuGrid GridOf(const ShapeMoment& moment) {
  const RemoteMesh& mesh = *moment.mesh;
  VtuGrid grid;
  grid.points = mesh.positions;
  grid.triangles = mesh.topology->surface.triangles;
  grid.lines = mesh.topology->lines;
  std::vector<Eigen::Vector3d> moved(mesh.positions), pressed(moved.size(), {0, 0, 0});
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= mesh.topology->surface.nodes[i];
  auto nodal = mesh.nodal_forces;
  for (const NamedFinger& finger : moment.fingers) {
    grid.vertices.push_back(static_cast<int>(grid.points.size()));
    grid.points.push_back(PlaceNow(finger.contact, mesh));
    moved.emplace_back(0, 0, 0);
    pressed.push_back(PressOf(finger.contact));
    if (!nodal.empty()) nodal.emplace_back(0, 0, 0);
  }
  PointArray displacement{"displacement", 3, {}, {}}, force{"finger_force", 3, {}, {}};
  Append(moved, &displacement);
  Append(pressed, &force);
  grid.arrays = {std::move(displacement), std::move(force)};
  if (nodal.empty()) return grid;
  grid.arrays.push_back({"nodal_force", 3, {}, {}});
  Append(nodal, &grid.arrays.back());
  return grid;
}

}  // namespace

void CheckShapeFile(const std::filesystem::path& file) {
  if (file.extension() == ".vtu") return;
  throw std::invalid_argument("--shape = " + file.string() +
                              ": expected a name that ends in .vtu (a mesh for ParaView)");
}

bool WriteShape(const ShapeMoment& moment, const std::filesystem::path& file) {
  return TryReplace(file, ToVtu(GridOf(moment), VtuForm::kAppended));
}

std::filesystem::path DeepestFile(const std::filesystem::path& file) {
  std::filesystem::path deepest = file;
  deepest.replace_filename(file.stem().string() + "-deepest" + file.extension().string());
  return deepest;
}

ShapeFile::ShapeFile(std::filesystem::path file,
                     std::function<std::shared_ptr<const RemoteMesh>()> newest)
    : file_(std::move(file)), newest_(std::move(newest)) {
  CheckShapeFile(file_);
  thread_ = std::jthread([this] { Run(); });
}

ShapeFile::~ShapeFile() {
  Finish();
}

void ShapeFile::Update(std::vector<NamedFinger> fingers) {
  const std::scoped_lock lock(mutex_);
  moment_.fingers = std::move(fingers);
}

std::string ShapeFile::Finish() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (failed_) return file_.string() + ": cannot be written";
  if (!deepest_.mesh) return file_.string() + ": not written: the slave sent no shape";
  return {};
}

void ShapeFile::Run() {
  while (true) {
    Write();
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kPeriod, [this] { return stopping_; })) break;
  }
  Write();
  if (deepest_.mesh) failed_ |= !WriteShape(deepest_, DeepestFile(file_));
}

void ShapeFile::Write() {
  ShapeMoment moment;
  {
    const std::scoped_lock lock(mutex_);
    moment = moment_;
  }
  moment.mesh = newest_();
  if (!moment.mesh) return;
  failed_ = !WriteShape(moment, file_);
  const bool deeper =
      !deepest_.mesh || moment.mesh->LargestDeflection() > deepest_.mesh->LargestDeflection();
  if (deeper) deepest_ = std::move(moment);
}

ShapeWatch::ShapeWatch(Observer* observer, const RemoteScene& scene,
                       const std::vector<std::filesystem::path>& files, bool table) {
  if (files.empty() && !(table && !scene.fingertips.empty())) return;
  observer_ = observer;
  observer_->Need(Observer::User::kShapes, {.mesh_rate = 5, .nodal_forces = !files.empty()});
  for (const auto& file : files) {
    files_.push_back(std::make_unique<ShapeFile>(file, [observer] { return observer->mesh(); }));
  }
}

std::shared_ptr<const RemoteMesh> ShapeWatch::newest() const {
  return observer_ != nullptr ? observer_->mesh() : nullptr;
}

void ShapeWatch::Update(const SessionStatus& status) {
  for (const auto& file : files_) file->Update(status.fingers);
}

bool ShapeWatch::Finish(Report* report) {
  if (observer_ == nullptr) return true;
  observer_->Need(Observer::User::kShapes, {});
  const Observer::MeshStats stats = observer_->mesh_stats();
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

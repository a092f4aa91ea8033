#include "master/recording/export.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "master/recording/replay.h"
#include "shared/mesh/vtu_writer.h"
#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kDigits = 9;

std::filesystem::path Made(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return folder;
}

std::string Numbered(std::uint64_t number, const char* ending) {
  return Formatted("%06llu%s", static_cast<unsigned long long>(number), ending);
}

VtuGrid GridOf(const RemoteMesh& mesh) {
  VtuGrid grid;
  grid.points = mesh.positions;
  grid.triangles = mesh.topology->surface.triangles;
  grid.lines = mesh.topology->lines;
  PointArray displacement{"displacement", 3, {}, {}};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3d u = mesh.positions[i] - mesh.topology->surface.nodes[i];
    displacement.values.insert(displacement.values.end(), u.begin(), u.end());
  }
  grid.arrays = {std::move(displacement)};
  if (mesh.traction.steps.empty()) return grid;
  grid.arrays.push_back({"traction", 1, {}, {}});
  for (const std::uint8_t steps : mesh.traction.steps) {
    grid.arrays.back().values.push_back(steps * mesh.traction.unit);
  }
  return grid;
}

// Writes meshes and the collection with their times for ParaView.
class MeshFiles {
 public:
  explicit MeshFiles(std::filesystem::path out) : out_(std::move(out)) {}

  void Add(double t, const RemoteMesh& mesh) {
    const std::string name = "meshes/" + Numbered(count_++, ".vtu");
    if (count_ == 1) Made(out_ / "meshes");
    if (!WriteVtu(out_ / name, GridOf(mesh), VtuForm::kAppended)) {
      throw std::runtime_error((out_ / name).string() + ": cannot be written");
    }
    listed_ += "  <DataSet timestep=\"";
    AppendNumber(&listed_, t, kDigits);
    listed_ += "\" file=\"" + name + "\"/>\n";
  }
  void Finish() const {
    if (count_ == 0) return;
    WriteWholeFile(out_ / "meshes.pvd",
                   "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n"
                   "<Collection>\n" +
                       listed_ + "</Collection>\n</VTKFile>\n");
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::filesystem::path out_;
  std::string listed_;
  std::uint64_t count_ = 0;
};

class SessionExport {
 public:
  SessionExport(Time begin, const std::filesystem::path& out)
      : begin_(begin), out_(Made(out)), meshes_(out_) {}

  [[nodiscard]] ReplayFeed Feed() {
    ReplayFeed feed;
    feed.on_tick = [this](const TickRecord& tick) { now_ = SecondsBetween(begin_, tick.at); };
    feed.on_state = [this](const SlaveState& state, Time at) {
      clock_offset_ = SecondsBetween(at, state.sent_at);
    };
    feed.on_picture = [this](const std::string& jpeg, Time taken) { Add(jpeg, taken); };
    feed.on_mesh = [this](const auto& mesh) { meshes_.Add(now_, *mesh); };
    return feed;
  }
  ExportCounts Finish() {
    if (counts_.images > 0) WriteWholeFile(out_ / "images.csv", "number,t\n" + times_);
    meshes_.Finish();
    counts_.meshes = meshes_.count();
    return counts_;
  }

 private:
  // Timestamps are of the slave's clock, whose offset is known within the network delay.
  void Add(const std::string& jpeg, Time taken) {
    if (counts_.images == 0) Made(out_ / "images");
    times_ += std::to_string(counts_.images) + ",";
    AppendNumber(&times_, SecondsBetween(begin_, taken) - clock_offset_, kDigits);
    times_ += "\n";
    WriteWholeFile(out_ / "images" / Numbered(counts_.images++, ".jpg"), jpeg);
  }

  const Time begin_;
  const std::filesystem::path out_;
  MeshFiles meshes_;
  std::string times_;                  // rows of images.csv
  double now_ = 0, clock_offset_ = 0;  // [s]
  ExportCounts counts_;
};

}  // namespace

ExportCounts ExportSession(const std::filesystem::path& file, const std::filesystem::path& out,
                           const std::stop_token& stop) {
  const Replay replay(file);
  SessionExport session(replay.span().first, out);
  replay.Play(0, 0, session.Feed(), stop);
  ExportCounts counts = session.Finish();
  counts.damage = replay.span().damage;
  return counts;
}

}  // namespace palpate

#include "master/recording/export.h"

#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "master/haptics/record/recorder.h"
#include "master/recording/replay.h"
#include "shared/mesh/files/vtu_writer.h"
#include "shared/recording/npy.h"
#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kDigits = 9;

std::span<const double> Row(const Eigen::Vector3d& v) {
  return {v.data(), 3};
}

std::filesystem::path Made(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  return folder;
}

std::string Numbered(std::uint64_t number, const char* ending) {
  return Formatted("%06llu%s", static_cast<unsigned long long>(number), ending);
}

std::uint64_t BitsOf(const Reasons& reasons) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (reasons.Has(static_cast<Reason>(i))) bits |= std::uint64_t{1} << i;
  }
  return bits;
}

// Writes one row per tick: motion, forces and their validity.
class TickArrays {
 public:
  explicit TickArrays(const std::filesystem::path& folder)
      : t_(NpyFile::Of<double>(folder / "t.npy", 1)),
        p_M_(NpyFile::Of<double>(folder / "p_M.npy", 3)),
        p_S_(NpyFile::Of<double>(folder / "p_S.npy", 3)),
        force_(NpyFile::Of<double>(folder / "force.npy", 3)),
        estimated_(NpyFile::Of<double>(folder / "estimated.npy", 3)),
        sigma_(NpyFile::Of<double>(folder / "sigma.npy", 1)),
        validity_(NpyFile::Of<std::uint8_t>(folder / "validity.npy", 1)),
        check_(NpyFile::Of<std::uint8_t>(folder / "check.npy", 1)),
        phase_(NpyFile::Of<std::uint8_t>(folder / "phase.npy", 1)),
        reasons_(NpyFile::Of<std::uint64_t>(folder / "reasons.npy", 1)),
        sequence_(NpyFile::Of<std::uint64_t>(folder / "state_sequence.npy", 1)),
        age_(NpyFile::Of<double>(folder / "age.npy", 1)),
        sensed_age_(NpyFile::Of<double>(folder / "sensed_age.npy", 1)),
        picture_(NpyFile::Of<std::int64_t>(folder / "picture.npy", 1)),
        marks_(NpyFile::Of<std::uint64_t>(folder / "marks.npy", 1)) {}

  void Add(double t, const TickRecord& tick, const SlaveState* state, std::int64_t picture) {
    const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kUnknown);
    const bool known = tick.chain.force_known;
    t_.Add(t);
    p_M_.Add(Row(tick.p_M));
    p_S_.Add(Row(tick.p_S));
    force_.Add(Row(tick.chain.sent));
    estimated_.Add(Row(known ? tick.chain.estimated : unknown));
    sigma_.Add(known && state ? state->sigma : kUnknown);
    validity_.Add(static_cast<std::uint8_t>(state ? ToProto(state->validity) : 0));
    check_.Add(static_cast<std::uint8_t>(state ? ToProto(state->check) : 0));
    phase_.Add(static_cast<std::uint8_t>(static_cast<int>(tick.state) + 1));
    reasons_.Add(BitsOf(tick.chain.reasons));
    sequence_.Add(tick.state_sequence);
    age_.Add(tick.state_age >= 0 ? tick.state_age : kUnknown);
    sensed_age_.Add(tick.state_age >= 0 ? tick.sensed_age : kUnknown);
    picture_.Add(picture);
    marks_.Add(std::uint64_t{tick.marks});
  }
  void Finish() {
    for (NpyFile* file :
         {&t_, &p_M_, &p_S_, &force_, &estimated_, &sigma_, &validity_, &check_, &phase_, &reasons_,
          &sequence_, &age_, &sensed_age_, &picture_, &marks_}) {
      file->Finish();
    }
  }

 private:
  NpyFile t_, p_M_, p_S_, force_, estimated_, sigma_, validity_, check_, phase_, reasons_,
      sequence_, age_, sensed_age_, picture_, marks_;
};

class StateTable {
 public:
  explicit StateTable(std::filesystem::path file) : file_(std::move(file)), out_(file_) {
    out_ << "t,sequence,tip_x,tip_y,tip_z,fx,fy,fz,sigma,validity,check,true_fx,true_fy,true_fz\n";
  }
  void Add(double t, const SlaveState& state) {
    std::string row;
    AppendNumber(&row, t, kDigits);
    row += "," + std::to_string(state.sequence);
    Append(state.p_S_tip, &row);
    Append(state.force, &row);
    row += ",";
    if (state.force) AppendNumber(&row, state.sigma, kDigits);
    row += "," + std::string(ToString(state.validity)) + "," + std::string(ToString(state.check));
    Append(state.true_force, &row);
    out_ << row << "\n";
  }
  void Finish() {
    out_.flush();
    if (!out_) throw std::runtime_error(file_.string() + ": cannot be written");
  }

 private:
  static void Append(const std::optional<Eigen::Vector3d>& v, std::string* row) {
    for (int i = 0; i < 3; ++i) {
      *row += ",";
      if (v) AppendNumber(row, (*v)[i], kDigits);
    }
  }

  std::filesystem::path file_;
  std::ofstream out_;
};

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
      : begin_(begin),
        out_(Made(out)),
        log_(out_ / "log.csv"),
        states_(out_ / "states.csv"),
        arrays_(Made(out_ / "numpy")),
        picture_t_(NpyFile::Of<double>(out_ / "numpy" / "picture_t.npy", 1)),
        meshes_(out_) {}

  [[nodiscard]] ReplayFeed Feed() {
    ReplayFeed feed;
    feed.on_tick = [this](const TickRecord& tick) { Add(tick); };
    feed.on_state = [this](const SlaveState& state, Time at) { Add(state, at); };
    feed.on_picture = [this](const std::string& jpeg, Time taken) { Add(jpeg, taken); };
    feed.on_mesh = [this](const auto& mesh) { meshes_.Add(now_, *mesh); };
    return feed;
  }
  ExportCounts Finish() {
    log_.Flush();
    if (!log_.trouble().empty()) throw std::runtime_error(log_.trouble());
    states_.Finish();
    arrays_.Finish();
    picture_t_.Finish();
    meshes_.Finish();
    counts_.meshes = meshes_.count();
    return counts_;
  }

 private:
  void Add(const TickRecord& tick) {
    constexpr std::uint64_t kFlushEvery = 1000;
    now_ = SecondsBetween(begin_, tick.at);
    log_.Add(now_, tick, tick.has_truth ? std::optional(tick.truth) : std::nullopt);
    if (++counts_.ticks % kFlushEvery == 0) log_.Flush();
    arrays_.Add(now_, tick, StateOf(tick), static_cast<std::int64_t>(counts_.pictures) - 1);
  }
  // The one that the tick went by; null: it is not kept. Newer ones may have been written already.
  [[nodiscard]] const SlaveState* StateOf(const TickRecord& tick) const {
    const auto found = recent_.find(tick.state_sequence);
    return found == recent_.end() ? nullptr : &found->second;
  }
  void Add(const SlaveState& state, Time at) {
    recent_[state.sequence] = state;
    if (recent_.size() > kRecent) recent_.erase(recent_.begin());
    ++counts_.states;
    clock_offset_ = SecondsBetween(at, state.sent_at);
    states_.Add(SecondsBetween(begin_, at), state);
  }
  // Timestamps are of the slave's clock, whose offset is known within the network delay.
  void Add(const std::string& jpeg, Time taken) {
    if (counts_.pictures == 0) Made(out_ / "pictures");
    WriteWholeFile(out_ / "pictures" / Numbered(counts_.pictures++, ".jpg"), jpeg);
    picture_t_.Add(SecondsBetween(begin_, taken) - clock_offset_);
  }

  const Time begin_;
  const std::filesystem::path out_;
  TickLog log_;
  StateTable states_;
  TickArrays arrays_;
  NpyFile picture_t_;
  MeshFiles meshes_;
  static constexpr std::size_t kRecent = 2000;
  std::map<std::uint64_t, SlaveState> recent_;  // by their sequence
  double now_ = 0, clock_offset_ = 0;           // [s]
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

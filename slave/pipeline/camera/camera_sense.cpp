#include "slave/pipeline/camera/camera_sense.h"

#include <limits>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/base/estimate_builder.h"
#include "slave/pipeline/camera/camera_overlay.h"
#include "slave/pipeline/manipulator_agreement/arm_lag.h"
#include "slave/pipeline/offline/offline_report.h"
#include "slave/program/plain_modulus.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

constexpr double kResolved = 0.05;  // resolution of the tip [px]
constexpr double kTryPeriod = 1;    // time between attempts to measure the baseline [s]
constexpr int kTries = 10;          // attempts to measure the rest state
// Smallest gap between tool and object in an image whose object is at rest [px]: several sigma of
// tip and edge. [by definition]
constexpr double kClear = 3;

std::unique_ptr<FrameSource> OpenTappedImages(const Scene& scene, const SenseInputs& inputs) {
  if (inputs.player != nullptr) return Tapped(inputs.player->OpenFrames(), inputs.tap);
  const auto straighten = StraighteningOf(*scene.sense.Find<Camera>());
  if (inputs.open) return Tapped(inputs.open(straighten), inputs.tap);
  if (inputs.images != nullptr) return Tapped(inputs.images->OpenFrames(straighten), inputs.tap);
  return Tapped(OpenFrameSource(scene, straighten), inputs.tap);
}

Frame FirstImageOf(FrameSource& source) {
  std::optional<Frame> first = source.Next({});
  if (!first) throw std::runtime_error(source.description() + ": no image received");
  return *std::move(first);
}

// Returns the tip in the first image: at its home, unless a template is searched.
std::optional<Eigen::Vector3d> ReportedTip(const Scene& scene) {
  if (scene.sense.Find<TipTracking>()->template_file.empty()) return scene.manipulator.home;
  return std::nullopt;
}

// Returns `local` with the object displaced from rest by `offset` [m], as the successor of `last`.
LocalModel Moved(LocalModel local, const Eigen::Vector3d& offset, const LocalModel& last) {
  if (!local.known()) return local;
  local.reference += offset;
  return Revised(local, last);
}

// Element nearest to `p_O` by midpoint.
int NearestElement(const BoundaryMesh& mesh, const Eigen::Vector2d& p_O) {
  int best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < mesh.size(); ++i) {
    const double d = (mesh.elements[static_cast<std::size_t>(i)].midpoint() - p_O).squaredNorm();
    if (d < nearest) nearest = d, best = i;
  }
  return best;
}

// Writes one row per image, with the force of the local model at the true depth.
class CameraOfflineReport final : public OfflineReport {
 public:
  explicit CameraOfflineReport(const CameraSense& sense) : sense_(sense) {}

  std::vector<StateRow> Add(Time start, const Truth* truth) override {
    const ContactEstimate& estimate = sense_.estimate();
    if (truth == nullptr) return {RowOf(estimate, start, std::nullopt)};
    compared_.push_back({estimate.force.value_or(kUnknownVector), truth->force,
                         ForceAt(estimate.local_model, truth->depth)});
    return {RowOf(estimate, start, truth->force)};
  }
  void OpenFrames(const std::filesystem::path& folder) override {
    std::filesystem::create_directories(folder);
  }
  void WriteFrame(const std::filesystem::path& folder) const override {
    const Frame& frame = sense_.frame();
    WriteWholeFile(folder / fmt::format("{:06}.png", frame.sequence), EncodePng(frame.image));
  }
  void Finish(OfflineSummary* summary) const override {
    const Registration& found = sense_.estimator().registration();
    summary->own["rest_surface"] = {
        {"measured", found.measured}, {"rms_px", found.rms_px}, {"points", found.points}};
  }

 private:
  const CameraSense& sense_;
};

}  // namespace

CameraSense::CameraSense(const Scene& scene, const SenseInputs& inputs)
    : scene_(scene),
      source_(OpenTappedImages(scene, inputs)),
      next_(FirstImageOf(*source_)),
      pixel_(scene.sense.Find<Camera>()->pixel),
      plane_(scene.model.plane),
      reason_(ChooseModel(scene).reason),
      solves_aside_(inputs.solves_aside),
      estimator_(std::make_shared<Estimator>(scene, next_, ReportedTip(scene),
                                             ObjectPlace::kNearPose, inputs.progress)) {
  if (solves_aside_) estimator_->touch().deformation->SolveAside();
}

bool CameraSense::Acquire(const std::stop_token& stop) {
  if (std::exchange(is_first_, false)) return true;
  std::optional<Frame> frame = source_->Next(stop);
  if (!frame) return false;
  next_ = *std::move(frame);
  return true;
}

const ContactEstimate& CameraSense::Estimate(const TipReading& encoders) noexcept {
  seen_ = next_;
  p_S_encoders_ = encoders.p_S_tip;
  if (IsRestartDue()) Restart();
  std::optional<EncoderReading> encoder;
  if (encoders.frame) {
    if (encoders.frame != encoder_frame_) estimator_->ForgetEncoders();
    encoder_frame_ = encoders.frame;
    encoder = {encoders.p_S_tip, kArmLag};
  }
  const LocalModel last = estimate_.local_model;
  if (!observation_) observation_ = estimator_->See(seen_);
  estimate_ = estimator_->Estimate(seen_, *observation_, encoder);
  observation_.reset();
  const Eigen::Vector3d& offset = motion().offset;
  estimate_.p_S_tip += offset;
  estimate_.p_S_contact += offset;
  estimate_.local_model = Moved(estimate_.local_model, offset, last);
  return estimate_;
}

void CameraSense::Reset(const std::function<bool()>& is_disengaged) {
  restarting_ = Restarting{estimator_->ApparentPose(), is_disengaged};
  estimator_->Reset();
  ReportTrouble({});
}

bool CameraSense::IsRestartDue() const noexcept {
  if (!restarting_) return false;
  return restarting_->tries == 0 || !restarting_->is_disengaged() ||
         SecondsBetween(restarting_->tried_at, next_.sensed_at) >= kTryPeriod;
}

void CameraSense::RequireDisengaged() const {
  if (!restarting_->is_disengaged()) throw std::logic_error("an operator is engaged");
}

void CameraSense::Restart() noexcept {
  restarting_->tried_at = seen_.sensed_at;
  ++restarting_->tries;
  observation_ = estimator_->See(seen_);
  try {
    RequireDisengaged();
    std::shared_ptr<Estimator> next = MeasureRestState();
    // What is pressed must not become the rest state.
    const double clear = kClear * next->tool_view().pixel();
    if (const double gap = next->GapAtStart(); gap < clear) {
      throw std::runtime_error(
          fmt::format("the tool is {:.2g} mm above the object: expected at least {:.2g} mm",
                      1e3 * gap, 1e3 * clear));
    }
    RequireDisengaged();  // the measurement has taken some time
    if (solves_aside_) next->touch().deformation->SolveAside();
    {
      const std::lock_guard lock(mutex_);
      estimator_ = std::move(next);
    }
    observation_.reset();
    restarting_.reset();
    ReportTrouble({});
  } catch (const std::exception& error) {
    const bool gives_up = restarting_->tries == kTries || !restarting_->is_disengaged();
    ReportTrouble(fmt::format("tracking is not reinitialized{}: {}",
                              gives_up ? ", call ReinitializeTracking again" : " yet",
                              error.what()));
    if (gives_up) restarting_.reset();
  }
}

std::shared_ptr<Estimator> CameraSense::MeasureRestState() const {
  Scene scene = scene_;
  scene.object.X_SO = restarting_->X_SO;
  // A template is searched in the whole image. Other tips need the encoder position.
  std::optional<Eigen::Vector3d> p_S_tip;
  if (scene.sense.Find<TipTracking>()->template_file.empty()) {
    const TipObservation& tip = observation_->tip;
    p_S_tip = tip.found ? estimator_->tool_view().ToSlave(tip.p_I) : p_S_encoders_;
  }
  auto* contour = scene.sense.Find<ContourTracking>();
  try {
    return std::make_shared<Estimator>(scene, seen_, p_S_tip);
  } catch (const std::runtime_error&) {
    if (contour == nullptr) throw;
  }
  // The object is not where the last image shows it.
  contour->start = {};
  return std::make_shared<Estimator>(scene, seen_, p_S_tip, ObjectPlace::kAnywhere);
}

void CameraSense::ReportTrouble(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  if (!trouble.empty() && trouble != trouble_) spdlog::warn("{}", trouble);
  trouble_ = trouble;
}

std::optional<CameraHealth> CameraSense::health() const {
  std::optional<CameraHealth> health = source_->health();
  const std::lock_guard lock(mutex_);
  if (trouble_.empty()) return health;
  if (!health) health.emplace();
  health->trouble = trouble_;
  return health;
}

std::unique_ptr<PreparedModel> CameraSense::Prepare(const Scene& changed,
                                                    Progress* progress) const {
  std::unique_lock lock(mutex_);
  const std::shared_ptr<const Estimator> estimator = estimator_;
  lock.unlock();
  return estimator->Prepare(changed, progress);
}

LocalModel CameraSense::LocalModelAt(const Eigen::Vector3d& p_S_tip) noexcept {
  const Eigen::Vector3d offset = motion().offset;
  const LocalModel local = estimator_->LocalAt(p_S_tip - offset);
  estimate_.local_model = Moved(local, offset, estimate_.local_model);
  return estimate_.local_model;
}

BoundaryShape CameraSense::Shape(const ShapeParts& parts) {
  const Eigen::Isometry3d& X_SO = estimator_->registration().X_SO;
  const BoundaryMesh& mesh = estimator_->touch().mesh;
  const Eigen::Vector3d moved = motion().offset;
  std::vector<Eigen::Vector3d> u_O;  // vertex i is the start of element i [m]
  TouchModel& touch = estimator_->touch();
  touch.deformation->Displacements(touch.pressed, &u_O);

  BoundaryShape shape = ShapeAsOf(estimate_, 2);
  shape.fixed_nodes = estimator_->touch().held;
  for (int i = 0; i < mesh.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    shape.elements.push_back(static_cast<std::uint32_t>(i));
    shape.elements.push_back(static_cast<std::uint32_t>(mesh.Next(i)));
    const Eigen::Vector2d& a = mesh.elements[k].a;
    const Eigen::Vector3d p_O(a.x(), a.y(), 0);
    Append(&shape.rest, moved + X_SO * p_O);
    Append(&shape.positions, moved + X_SO * (p_O + u_O[k]));
  }
  if (parts.field) shape.field = Field();
  if (!parts.nodal_forces || !estimate_.force) return shape;
  shape.nodal_forces.assign(3 * mesh.elements.size(), 0.0F);
  shape.traction.assign(mesh.elements.size(), 0.0F);
  if (!estimate_.local_model.in_contact) return shape;
  touch.deformation->Tractions(touch.pressed, &shape.traction);
  const Eigen::Vector3d p_O = X_SO.inverse() * (estimate_.p_S_contact - moved);
  const int element = NearestElement(mesh, p_O.head<2>());
  for (const int vertex : {element, mesh.Next(element)}) {
    for (int axis = 0; axis < 3; ++axis) {
      shape.nodal_forces[3 * static_cast<std::size_t>(vertex) + static_cast<std::size_t>(axis)] =
          static_cast<float>(-0.5 * (*estimate_.force)[axis]);
    }
  }
  return shape;
}

DisplacementField CameraSense::Field() {
  const Eigen::Isometry3d& X_SO = estimator_->registration().X_SO;
  const Eigen::Vector3d moved = motion().offset;
  TouchModel& touch = estimator_->touch();
  std::vector<Eigen::Vector3d> u_O;
  touch.deformation->CoverDisplacements(touch.pressed, &u_O);
  const PlanarCover& cover = touch.deformation->cover();
  DisplacementField field;
  for (const auto& triangle : cover.triangles) {
    field.triangles.insert(field.triangles.end(), triangle.begin(), triangle.end());
  }
  const auto outline = touch.mesh.elements.size();
  for (std::size_t i = 0; i < u_O.size(); ++i) {
    const Eigen::Vector2d& p = i < outline ? touch.mesh.elements[i].a : cover.inside[i - outline];
    const Eigen::Vector3d p_O = Planar(p);
    Append(&field, p_O, u_O[i], estimator_->view().ToImage(moved + X_SO * (p_O + u_O[i])));
  }
  return field;
}

std::optional<OverlaidImage> CameraSense::Image(double full_scale) const {
  if (seen_.image.empty()) return std::nullopt;
  const CameraObservation& shown = estimator_->observation();
  CameraOverlay overlay{
      estimator_->edge_I(), shown.search_window, shown.tip, estimate_.force, {0, 0}};
  if (estimate_.force) {
    overlay.force_I = ForceArrow(estimator_->tool_view(), estimate_.p_S_tip, *estimate_.force,
                                 full_scale, seen_.image.rows);
    overlay.sigma = estimate_.sigma;
    overlay.sigma_I = overlay.force_I.norm() * estimate_.sigma / estimate_.force->norm();
  }
  return OverlaidImage{seen_.sensed_at, seen_.image,
                       [image = seen_.image, overlay] { return Draw(overlay, image); }};
}

void CameraSense::Adopt(std::unique_ptr<PreparedModel> prepared, const Scene& changed) {
  std::unique_ptr<TouchModel> touch(static_cast<TouchModel*>(prepared.release()));
  // The outline in the image may have been measured again meanwhile.
  if (touch->outline != estimator_->registration().seen) touch = estimator_->Prepare(changed);
  if (solves_aside_) touch->deformation->SolveAside();
  estimator_->Adopt(std::move(touch), changed);
  scene_ = changed;
}

SenseInfo CameraSense::info() const {
  SenseInfo info;
  info.source = source_->description();
  info.samples = "images";
  info.tip_resolution = kResolved * pixel_;
  info.model = estimator_->touch().info();
  info.reason = reason_;
  if (FindModelKind(info.model.kind)->is_plane) {
    info.remarks.emplace_back(plane_ == Plane::kStress ? "in plane stress" : "in plane strain");
  }
  if (const double K = estimator_->touch().stiffness_at_home; K > 0) {
    info.remarks.push_back("1 mm deep the tool presses with " + ForceText(1e-3 * K));
  }
  const Registration& found = estimator_->registration();
  if (found.measured) {
    info.remarks.push_back(fmt::format("rest surface found in the image: {} points, {:.3f} px rms",
                                       found.points, found.rms_px));
  }
  info.object = ObjectClass::kOutline;
  return info;
}

std::vector<StageTimes> CameraSense::Stages() const {
  const StageHistograms& times = estimator_->times();
  return {TimesOf("vision", times.vision), TimesOf("checks", times.checks),
          TimesOf("contact", times.contact), TimesOf("mechanics", times.mechanics),
          TimesOf("total", times.total)};
}

std::unique_ptr<OfflineReport> CameraSense::OpenOfflineReport(const GroundTruth* /*truth*/) {
  return std::make_unique<CameraOfflineReport>(*this);
}

}  // namespace palpate

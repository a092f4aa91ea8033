#include "slave/commands/serve/setup_session.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "shared/text/text.h"
#include "shared/wire/enum_names.h"
#include "slave/capture/bounded_image.h"
#include "slave/checks/camera/camera_limits.h"
#include "slave/commands/check/check.h"
#include "slave/commands/scene_remarks.h"
#include "slave/commands/serve/scene_mistakes.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/program/private_folder.h"
#include "slave/scene/document.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/scene_text.h"
#include "slave/vision/tool_end.h"

namespace palpate {
namespace {

constexpr const char* kSceneName = "scene.yaml";
constexpr std::size_t kMaxNameLength = 60;
constexpr std::size_t kMaxProposalBytes = std::size_t{32} << 20;

[[noreturn]] void RefuseFile(const std::string& name, const std::string& accepted) {
  throw std::invalid_argument("files[" + Presentable(name, kMaxNameLength) + "]: expected " +
                              accepted);
}

void RequireName(const std::string& name) {
  if (!IsSetupFile(name)) RefuseFile(name, "tip.png, outline.csv, lens.yaml or image.jpg");
}

void RequireFiles(const SceneProposal& proposal) {
  std::size_t bytes = proposal.scene.size();
  for (const auto& [name, content] : proposal.files) {
    RequireName(name);
    bytes += content.size();
  }
  if (bytes > kMaxProposalBytes) {
    throw std::invalid_argument(
        fmt::format("scene and files of {:.1f} MB: expected at most 32 MiB together",
                    1e-6 * static_cast<double>(bytes)));
  }
  // The scene may name each of these as an image.
  for (const auto& [name, content] : proposal.files) {
    if (name.ends_with(".png") || name.ends_with(".jpg")) {
      RequireBounded({&content, 1});
    } else if (content.find('\0') != std::string::npos) {
      RefuseFile(name, "text");
    }
  }
}

// The text of a report names the files as the proposal does.
std::string WithoutFolder(std::string text, const std::filesystem::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = text.find(prefix); at != std::string::npos; at = text.find(prefix, at)) {
    text.erase(at, prefix.size());
  }
  return text;
}

std::string LinesOf(const SharedCamera& camera) {
  std::string lines = camera.SceneLines();
  std::ranges::replace(lines, '\n', ' ');
  return lines;
}

SceneMistake OtherCamera(const SharedCamera& camera) {
  return {.key = "sense.camera",
          .message = "not the camera of this set-up",
          .expected = "the lines of SceneDescription.setup_camera: " + LinesOf(camera)};
}

// Returns whether a name points outside of the scene's folder.
bool LeavesFolder(const std::filesystem::path& name) {
  return name.is_absolute() || std::ranges::find(name, "..") != name.end();
}

// Finds values that name files outside the proposal, before any file is opened.
void AddForeignNames(const DocumentNode& node, const std::string& path, const SharedCamera& camera,
                     std::vector<SceneMistake>* mistakes) {
  constexpr std::size_t kMaxMistakes = 50, kMaxPathLength = 200;
  for (const DocumentNode& child : node.children) {
    if (mistakes->size() >= kMaxMistakes) return;
    const bool is_known = path.size() < kMaxPathLength;  // no key of a scene has a longer one
    const std::string below = path.empty() ? child.key : is_known ? path + "." + child.key : path;
    AddForeignNames(child, below, camera, mistakes);
  }
  if (node.kind != DocumentNode::Kind::kScalar) return;
  if (path == "sense.camera.file" || path == "sense.camera.url") {
    if (node.text == camera.camera().pattern) return;
    mistakes->push_back(OtherCamera(camera));
  } else if (LeavesFolder(node.text)) {
    mistakes->push_back({.key = Shown(path),
                         .value = Shown(node.text),
                         .message = "a file outside the proposal",
                         .expected = "the name of one of its files"});
  } else {
    return;
  }
  mistakes->back().line = node.line;
}

// A client chooses the model. Memory of boundary elements rises with the square of their number:
// 1000 take 60 MB.
void AddCost(const Scene& scene, std::vector<SceneMistake>* mistakes) {
  constexpr int kMaxElements = 1000;
  constexpr long kMaxCells = 20'000;
  if (scene.model.elements > kMaxElements) {
    mistakes->push_back({.key = "model.elements",
                         .value = std::to_string(scene.model.elements),
                         .message = "more than a set-up computes",
                         .expected = fmt::format("at most {}", kMaxElements)});
  }
  const auto* box = std::get_if<BoxGeometry>(&scene.object.geometry);
  if (box == nullptr) return;
  const double cells = double{1} * box->cells[0] * box->cells[1] * box->cells[2];
  if (cells <= kMaxCells) return;
  mistakes->push_back({.key = "object.geometry.box.cells",
                       .value = fmt::format("{:.0f} cells", cells),
                       .message = "more than a set-up computes",
                       .expected = fmt::format("at most {}", kMaxCells)});
}

// Lists the parts of a scene that a set-up does not permit: another camera, or another client.
std::vector<SceneMistake> ForeignParts(const Scene& scene, const SharedCamera& camera) {
  std::vector<SceneMistake> mistakes;
  const auto* used = scene.sense.Find<Camera>();
  if (used == nullptr || !camera.IsOpenedBy(*used)) mistakes.push_back(OtherCamera(camera));
  if (scene.manipulator.source == ManipulatorOptions::Source::kStream) {
    mistakes.push_back({.key = "manipulator.source",
                        .value = "stream",
                        .message = "a driver cannot connect during the set-up",
                        .expected = "`manipulator: none`, or another source after the set-up"});
  }
  AddCost(scene, &mistakes);
  return mistakes;
}

double LargerSideOf(const Scene& scene) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : OutlineOf(scene.object.geometry).outer) box.extend(p);
  return box.isEmpty() ? 0 : box.sizes().maxCoeff();
}

// The sensing on the image with which it would start.
struct Trial {
  SenseInfo info;
  ContactEstimate estimate;
  std::optional<SceneMistake> tool;  // the scene's tool is not the one in the image
};

// Compares the tool at the detected tip with the scene's tool. The position of a round end is not
// compared.
std::optional<SceneMistake> CompareTool(const Scene& scene, const CameraSense& sense) {
  const Estimator& estimator = sense.estimator();
  const TipObservation& tip = estimator.observation().tip;
  const Eigen::Vector2d d_I = Eigen::Rotation2Dd(tip.turn) * estimator.tracker().tool_direction_I();
  if (!tip.found || d_I.isZero(0)) return std::nullopt;
  const cv::Mat& image = sense.frame().image;
  const ToolEndSize tool = EndSizeOf(*scene.tool, estimator.tool_view().pixel());
  const GreyFormat format(image);
  const auto end = DetectToolEnd(image, format, tip.p_I, d_I, tool);
  if (!end) {
    if (!ToolGoesOn(image, format, tip.p_I, d_I, tool)) return std::nullopt;
    return SceneMistake{.key = "sense.tip.template",
                        .message = "the tool goes on beyond the tip",
                        .expected = "an image of the end of the tool"};
  }
  if (std::abs(end->width / tool.width - 1) > CameraLimits::kToolWidth) {
    return SceneMistake{.key = "tool.width",
                        .value = LengthInWords(scene.tool->width),
                        .message = "another width than in the image",
                        .expected = LengthInWords(end->width * estimator.tool_view().pixel())};
  }
  // Two standard deviations of what the scene states of the anchor.
  const double off_along = 2 * scene.sense.Find<TipTracking>()->anchor_tolerance;
  const bool is_elsewhere = std::abs(end->beyond) > CameraLimits::kToolElsewhere + off_along ||
                            std::abs(end->aside) > CameraLimits::kToolElsewhere;
  if (!is_elsewhere || scene.tool->shape != Tool::Shape::kFlat) return std::nullopt;
  const Eigen::Vector2d off = end->beyond * d_I + end->aside * Eigen::Vector2d(-d_I.y(), d_I.x());
  return SceneMistake{
      .key = "sense.tip.anchor",
      .message = "not the end of the tool in the image",
      .expected = fmt::format("a point {:+.1f} px to the right and {:+.1f} px further down",
                              off.x(), off.y())};
}

Trial TrySensing(const Scene& scene, const FrameOpener& open, Progress* progress) {
  CameraSense sense(scene, {.open = open, .progress = progress});
  if (!sense.Acquire({})) throw std::runtime_error("no image received");
  sense.Process();
  Trial trial;
  trial.estimate = sense.Estimate({scene.manipulator.home, std::nullopt});
  trial.info = sense.info();
  trial.tool = CompareTool(scene, sense);
  return trial;
}

std::string Lines(const Trial& trial) {
  ReportCollector report;
  for (const std::string& remark : trial.info.remarks) PrintLine("image", remark);
  const ContactEstimate& now = trial.estimate;
  PrintLine("tip",
            now.details.score
                ? fmt::format("found in the image at the start, score {:.2f}", *now.details.score)
                : std::string("not in the image at the start: it is found when it appears"));
  if (now.details.score && now.validity != Validity::kValid) {
    PrintLine("flagged", fmt::format("{}: {}", ToString(now.check), now.reason));
  }
  return report.text;
}

std::optional<SceneMistake> TouchAtStart(const Trial& trial) {
  if (!(trial.estimate.depth > 0)) return std::nullopt;
  return SceneMistake{.key = "sense.tip",
                      .message = fmt::format("the tool touches the object in the image at the "
                                             "start, {:.2g} mm deep",
                                             1e3 * trial.estimate.depth),
                      .expected = "an untouched object: lift the tool, or correct its tip"};
}

// The mistakes of a staged scene or, without any, the scene and its trial.
struct Examined {
  std::vector<SceneMistake> mistakes;
  FrameOpener open;  // its first image is that of the trial
  Scene scene;
  Trial trial;
};

FrameOpener OpenerOf(const SharedCamera& camera, std::optional<Frame> first = {}) {
  return [&camera, first = std::move(first)](const ImageFilter& filter) {
    return camera.Open(filter, first);
  };
}

Frame FreshFrame(const SharedCamera& camera, const std::stop_token& stop) {
  std::optional<Frame> frame = camera.Fresh(stop);
  if (stop.stop_requested()) throw Interrupted();
  if (!frame) throw std::runtime_error("no image received");
  return *std::move(frame);
}

// Examines the proposed scene `file`. Its folder contains only this proposal.
Examined Examine(const std::filesystem::path& file, const SharedCamera& camera,
                 Progress* progress) {
  Examined examined;
  std::vector<SceneMistake>& mistakes = examined.mistakes;
  try {
    Mistakes unreadable(file);
    AddForeignNames(ReadDocument(file, {}, &unreadable), "", camera, &mistakes);
    if (!mistakes.empty()) return examined;
    examined.scene = LoadRunningScene(file, {});
    ReportProgress(progress, "scene", 0.1);
    mistakes = ForeignParts(examined.scene, camera);
    if (!mistakes.empty()) return examined;
    examined.open = OpenerOf(camera, FreshFrame(camera, StopOf(progress)));
    examined.trial = TrySensing(examined.scene, examined.open, progress);
    if (examined.trial.tool) {
      mistakes.push_back(*examined.trial.tool);
    } else if (const auto touch = TouchAtStart(examined.trial)) {
      mistakes.push_back(*touch);
    }
  } catch (const Interrupted&) {
    throw;
  } catch (const SceneError& error) {
    mistakes = MistakesOf(error);
  } catch (const std::exception& error) {
    std::string message = error.what();
    const std::string prefix = file.string() + ": ";
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
    mistakes.push_back(MistakeIn(WithoutFolder(std::move(message), file.parent_path())));
  }
  for (SceneMistake& mistake : mistakes) {
    mistake.expected = WithoutFolder(std::move(mistake.expected), file.parent_path());
  }
  return examined;
}

}  // namespace

// If Use is not called, the scene is removed and its slave ends.
class SetupSession::Prepared final : public PreparedScene {
 public:
  Prepared(SetupSession& session, const SceneProposal& proposal)
      : session_(session), draft_(session.saved_, proposal) {}

  void Start(const Scene& scene, const FrameOpener& open, Progress* progress) {
    slave_ = session_.Offered(MakeLiveSlave(scene, {}, nullptr, open, progress));
  }
  [[nodiscard]] std::filesystem::path file() const { return draft_.file(); }
  [[nodiscard]] SlaveDescription Describe() const override { return slave_->Describe(); }
  void Use() override {
    draft_.Use();
    session_.Serve(std::move(slave_));
  }

 private:
  SetupSession& session_;
  SavedScenes::Draft draft_;
  std::unique_ptr<LiveSlave> slave_;
};

SetupSession::SetupSession(const std::filesystem::path& folder, const Camera& camera)
    : camera_(camera), saved_(folder) {}

cv::Mat SetupSession::StartImage(const std::stop_token& stop) {
  return FreshFrame(camera_, stop).image;
}

ProposalReport SetupSession::Check(const SceneProposal& proposal, Progress* progress) {
  RequireFiles(proposal);
  const PrivateFolder folder;
  WriteProposal(proposal, folder.path());
  const std::filesystem::path file = folder.path() / kSceneName;
  ReportProgress(progress, "scene", 0);
  ProposalReport report;
  const Examined examined = Examine(file, camera_, progress);
  report.mistakes = examined.mistakes;
  if (!report.mistakes.empty()) return report;
  ReportProgress(progress, "check", 0.5);
  {
    ReportCollector printed;
    RunCheck({file, {}, progress});
    report.text = WithoutFolder(printed.text, folder.path());
    if (printed.contact) {
      const ReportedContact& contact = *printed.contact;
      report.contact = {contact.depth, contact.force,
                        examined.trial.info.model.range * LargerSideOf(examined.scene),
                        contact.update};
    }
  }
  report.text += Lines(examined.trial);
  report.description.scene = examined.scene;
  report.description.sense = examined.trial.info;
  report.description.setup_camera = camera_.SceneLines();
  return report;
}

std::unique_ptr<PreparedScene> SetupSession::Prepare(const SceneProposal& proposal,
                                                     Progress* progress) {
  RequireFiles(proposal);
  auto prepared = std::make_unique<Prepared>(*this, proposal);
  ReportProgress(progress, "scene", 0);
  const Examined examined = Examine(prepared->file(), camera_, progress);
  if (!examined.mistakes.empty()) throw std::invalid_argument(InWords(examined.mistakes));
  ReportProgress(progress, "model", 0.5);
  prepared->Start(examined.scene, examined.open, progress);
  return prepared;
}

std::unique_ptr<LiveSlave> SetupSession::Offered(std::unique_ptr<LiveSlave> slave) {
  slave->OfferSetup(this, camera_.SceneLines());
  return slave;
}

std::unique_ptr<LiveSlave> SetupSession::First() {
  std::error_code none;
  if (std::filesystem::exists(saved_.file(), none)) {
    try {
      const Scene scene = LoadRunningScene(saved_.file(), {});
      const std::vector<SceneMistake> foreign = ForeignParts(scene, camera_);
      if (!foreign.empty()) throw std::invalid_argument(InWords(foreign));
      return Offered(MakeLiveSlave(scene, {}, nullptr, OpenerOf(camera_)));
    } catch (const std::exception& error) {
      spdlog::warn("the saved scene is not used, and the set-up begins without one: {}",
                   error.what());
    }
  }
  return Offered(MakePreviewSlave(camera_.camera(), OpenerOf(camera_)));
}

void SetupSession::Serve(std::unique_ptr<LiveSlave> next) {
  {
    const std::scoped_lock lock(mutex_);
    next_ = std::move(next);
  }
  changed_.notify_all();
}

std::unique_ptr<LiveSlave> SetupSession::Next(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return next_ != nullptr; });
  return std::move(next_);
}

}  // namespace palpate

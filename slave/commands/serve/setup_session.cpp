#include "slave/commands/serve/setup_session.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/checks/camera/camera_limits.h"
#include "slave/commands/check/check.h"
#include "slave/commands/running_scene.h"
#include "slave/live/live_slave.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/program/private_folder.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/words.h"
#include "slave/vision/tool_end.h"

namespace palpate {
namespace {

constexpr const char* kSceneName = "scene.yaml";
constexpr std::size_t kMostFiles = 32, kLongestName = 64;
constexpr std::size_t kMostBytes = std::size_t{32} << 20;

[[noreturn]] void RefuseFile(const std::string& name, const std::string& accepted) {
  throw std::invalid_argument("files[" + Presentable(name, kLongestName) + "]: expected " +
                              accepted);
}

void RequireName(const std::string& name) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
  };
  const bool is_good = !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
                       std::ranges::all_of(name, is_plain) && name != kSceneName;
  if (is_good) return;
  RefuseFile(name, std::string("a name of letters, digits, `.`, `_` and `-`, without a folder, "
                               "other than ") +
                       kSceneName);
}

void RequireFiles(const SceneProposal& proposal) {
  std::size_t bytes = proposal.scene.size();
  for (const auto& [name, content] : proposal.files) {
    RequireName(name);
    bytes += content.size();
  }
  if (proposal.files.size() > kMostFiles || bytes > kMostBytes) {
    throw std::invalid_argument(fmt::format("files: {} of {:.1f} MB: expected at most {} of 32 MiB",
                                            proposal.files.size(),
                                            1e-6 * static_cast<double>(bytes), kMostFiles));
  }
}

void Replace(std::string* text, const std::string& from, const std::string& to) {
  for (std::size_t at = text->find(from); at != std::string::npos; at = text->find(from, at)) {
    text->replace(at, from.size(), to);
    at += to.size();
  }
}

// A proposal as files, and the scene that they are.
class StagedScene {
 public:
  explicit StagedScene(const SceneProposal& proposal) : file_(folder_.path() / kSceneName) {
    RequireFiles(proposal);
    WriteWholeFile(file_, proposal.scene);
    for (const auto& [name, content] : proposal.files) {
      WriteWholeFile(folder_.path() / name, content);
    }
  }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }
  // Texts name the files as the proposal does.
  [[nodiscard]] std::string Shown(std::string text) const {
    Replace(&text, folder_.path().string() + "/", "");
    return text;
  }
  [[nodiscard]] SceneMistake Mistake(const std::string& text) const {
    SceneMistake mistake = ParseMistake(text, file_);
    for (std::string* part : {&mistake.value, &mistake.message, &mistake.expected}) {
      *part = Shown(*part);
    }
    return mistake;
  }

 private:
  PrivateFolder folder_;
  std::filesystem::path file_;
};

// The scene must show the images of the set-up, read no other files, and need no other client.
std::vector<SceneMistake> ForeignParts(const Scene& scene, const StagedScene& staged,
                                       const SharedCamera& camera) {
  std::vector<SceneMistake> mistakes;
  const auto* used = scene.sense.Find<Camera>();
  if (used == nullptr || !camera.IsOpenedBy(*used)) {
    std::string lines = camera.SceneLines();
    std::ranges::replace(lines, '\n', ' ');
    mistakes.push_back({.key = "sense.camera",
                        .message = "not the camera of this set-up",
                        .expected = "the lines of SceneDescription.setup_camera: " + lines});
  }
  if (scene.manipulator.source == ManipulatorOptions::Source::kStream) {
    mistakes.push_back({.key = "manipulator.source",
                        .value = "stream",
                        .message = "a driver cannot connect during the set-up",
                        .expected = "`manipulator: none`, or another source after the set-up"});
  }
  for (const std::filesystem::path& input : InputFilesOf(scene)) {
    const bool is_image =
        used != nullptr &&
        (input == used->pattern || input == std::filesystem::path(used->pattern).parent_path());
    if (is_image || input.lexically_normal().parent_path() == staged.folder()) continue;
    mistakes.push_back({.value = input.string(),
                        .message = "a file outside the proposal",
                        .expected = "the name of one of its files"});
  }
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

// The tool at the tip that was found, against the scene's. A round end is not measured.
std::optional<SceneMistake> CompareTool(const Scene& scene, const CameraSense& sense) {
  const Estimator& estimator = sense.estimator();
  const TipObservation& tip = estimator.observation().tip;
  const Eigen::Vector2d d_I = Eigen::Rotation2Dd(tip.turn) * estimator.tracker().tool_direction_I();
  if (!tip.found || d_I.isZero(0)) return std::nullopt;
  const cv::Mat& image = sense.frame().image;
  const double width = scene.tool->width / estimator.view().pixel();
  const GreyFormat format(image);
  const auto end = DetectToolEnd(image, format, tip.p_I, d_I, width);
  if (!end) {
    if (!ToolGoesOn(image, format, tip.p_I, d_I, width)) return std::nullopt;
    return SceneMistake{.key = "sense.tip.template",
                        .message = "the tool goes on beyond the tip",
                        .expected = "an image of the end of the tool"};
  }
  if (std::abs(end->width / width - 1) > CameraLimits::kToolWidth) {
    return SceneMistake{.key = "tool.width",
                        .value = LengthInWords(scene.tool->width),
                        .message = "another width than in the image",
                        .expected = LengthInWords(end->width * estimator.view().pixel())};
  }
  const bool is_elsewhere = std::abs(end->beyond) > CameraLimits::kToolElsewhere ||
                            std::abs(end->aside) > CameraLimits::kToolElsewhere;
  if (!is_elsewhere || scene.tool->shape != Tool::Shape::kFlat) return std::nullopt;
  const Eigen::Vector2d off = end->beyond * d_I + end->aside * Eigen::Vector2d(-d_I.y(), d_I.x());
  return SceneMistake{
      .key = "sense.tip.anchor",
      .message = "not the end of the tool in the image",
      .expected = fmt::format("a point {:+.1f} px to the right and {:+.1f} px further down",
                              off.x(), off.y())};
}

Trial TrySensing(const Scene& scene, const FrameOpener& open) {
  CameraSense sense(scene, Pace{.open = open});
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

std::string InWords(const std::vector<SceneMistake>& mistakes) {
  std::string words;
  for (const SceneMistake& mistake : mistakes) {
    words += words.empty() ? "" : "\n";
    if (mistake.line > 0) words += fmt::format("line {}: ", mistake.line);
    words += mistake.key;
    if (!mistake.value.empty()) words += " = " + mistake.value;
    if (!mistake.message.empty()) words += (mistake.key.empty() ? "" : ": ") + mistake.message;
    if (!mistake.expected.empty()) words += ": expected " + mistake.expected;
  }
  return words;
}

// What is wrong with a staged scene; if nothing is, the scene and its trial.
struct Examined {
  std::vector<SceneMistake> mistakes;
  Scene scene;
  Trial trial;
};

Examined Examine(const StagedScene& staged, const SharedCamera& camera, const FrameOpener& open) {
  Examined examined;
  try {
    examined.scene = LoadRunningScene(staged.file(), {});
    examined.mistakes = ForeignParts(examined.scene, staged, camera);
    if (!examined.mistakes.empty()) return examined;
    examined.trial = TrySensing(examined.scene, open);
    if (examined.trial.tool) {
      examined.mistakes.push_back(*examined.trial.tool);
    } else if (const auto touch = TouchAtStart(examined.trial)) {
      examined.mistakes.push_back(*touch);
    }
  } catch (const SceneError& error) {
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);) {
      examined.mistakes.push_back(staged.Mistake(line));
    }
  } catch (const std::exception& error) {
    examined.mistakes.push_back(staged.Mistake(error.what()));
  }
  return examined;
}

}  // namespace

SceneMistake ParseMistake(std::string text, const std::filesystem::path& file) {
  SceneMistake mistake;
  static const std::regex place("^:([0-9]+): |^: ");
  static const std::regex assigned(
      R"(^([a-z_]+(?:\.[A-Za-z_0-9]+)*) = ([{\[].*[}\]]|.*?)(?:: (.*))?$)");
  static const std::regex named(R"(^([a-z_]+(?:\.[a-z_0-9]+)+): (.*)$)");
  static const std::regex mentioned(
      R"((?:object|sense|tool|model|manipulator|operator)(?:\.[a-z_]+)+|camera\.[a-z_]+)");
  std::smatch match;
  if (text.starts_with(file.string())) {
    text.erase(0, file.string().size());
    if (std::regex_search(text, match, place)) {
      if (match[1].matched) mistake.line = std::stoi(match[1]);
      text = match.suffix();
    }
  }
  constexpr std::string_view kExpected = ": expected ";
  if (const std::size_t at = text.rfind(kExpected); at != std::string::npos) {
    mistake.expected = text.substr(at + kExpected.size());
    text.erase(at);
  }
  if (std::regex_match(text, match, assigned)) {
    mistake.key = match[1];
    const bool is_missing = match[2] == "(missing)";
    if (!is_missing) mistake.value = match[2];
    mistake.message = match[3].matched ? match[3].str() : is_missing ? "missing" : "not accepted";
  } else if (std::regex_match(text, match, named)) {
    mistake.key = match[1];
    mistake.message = match[2];
  } else {
    if (std::regex_search(text, match, mentioned)) mistake.key = match[0];
    mistake.message = text;
  }
  if (mistake.key.starts_with("camera.")) mistake.key.insert(0, "sense.");
  return mistake;
}

SetupSession::SetupSession(SetupOptions options, const Camera& camera)
    : options_(std::move(options)),
      camera_(camera),
      slave_(MakePreviewSlave(camera_.camera(), Opener()), camera_.SceneLines(), this) {
  std::filesystem::create_directories(options_.folder);
}

FrameOpener SetupSession::Opener() const {
  return [this](const PictureFilter& filter) { return camera_.Open(filter); };
}

cv::Mat SetupSession::StartImage() {
  const auto frame = camera_.Open()->Next({});
  if (!frame) throw std::runtime_error("no image received");
  return frame->image;
}

ProposalReport SetupSession::Check(const SceneProposal& proposal, Progress* progress) {
  const StagedScene staged(proposal);
  ReportProgress(progress, "scene", 0);
  ProposalReport report;
  const Examined examined = Examine(staged, camera_, Opener());
  report.mistakes = examined.mistakes;
  if (!report.mistakes.empty()) return report;
  ReportProgress(progress, "check", 0.5);
  {
    ReportCollector collector;
    RunCheck({staged.file(), {}});
    report.text = staged.Shown(collector.text);
    if (collector.contact) {
      const ReportedContact& contact = *collector.contact;
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

std::function<void()> SetupSession::Prepare(const SceneProposal& proposal, Progress* progress) {
  const StagedScene staged(proposal);
  ReportProgress(progress, "scene", 0);
  const Examined examined = Examine(staged, camera_, Opener());
  if (!examined.mistakes.empty()) throw std::invalid_argument(InWords(examined.mistakes));
  ReportProgress(progress, "model", 0.5);
  for (const auto& [name, content] : proposal.files) ReplaceFile(options_.folder / name, content);
  ReplaceFile(options_.folder / kSceneName, proposal.scene);
  const Scene scene = LoadRunningScene(options_.folder / kSceneName, {});
  std::shared_ptr<Slave> next =
      MakeLiveSlave(scene, options_.state_dir, nullptr, options_.choose, Opener());
  return [this, next] { slave_.Replace(next); };
}

}  // namespace palpate

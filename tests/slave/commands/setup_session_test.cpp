// The set-up on painted images of the shipped block: a scene is proposed, saved, used, and gives
// forces.
#include "slave/commands/serve/setup_session.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/commands/serve/scene_mistakes.h"
#include "slave/pipeline/camera/camera_sense.h"
#include "slave/program/private_folder.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/vision/outline_finder.h"
#include "slave/vision/tool_end.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

// Positions of tool and block in the first image, from the scene: the tip at home, 0.35 mm per
// pixel; the block is displaced from its pose by `site.misplacement`.
const Vector2d kTip(319.5, 239.5 - 40.16 / 0.35);
const Vector2d kLowerLeft(319.5 + (0.21 - 44) / 0.35, 239.5 + (54 + 0.13) / 0.35);
constexpr double kSquareSide = 88 / 0.35;

class SetupSessionTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new PrivateFolder;
    const Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"),
                                  {"operator.press.depth=2 mm", "sense.camera.rate=30 Hz"});
    const auto environment = MakeSimulatedEnvironment(scene);
    const auto camera = environment->OpenCamera(scene, ScriptedRun{});
    std::filesystem::create_directories(folder_->path() / "images");
    while (const auto frame = camera->Next({})) {
      std::ostringstream name;
      name << "images/" << 1000 + frame->sequence << ".png";
      std::ofstream(folder_->path() / name.str(), std::ios::binary) << EncodePng(frame->image);
      true_force_[frame->sequence] = environment->truth().force.y();
      if (frame->sequence == 1) first_ = frame->image.clone();
    }
  }
  static void TearDownTestSuite() { delete folder_; }

  // A proposal as a user would write it; `modulus` is that of the block, or a mistake.
  [[nodiscard]] SceneProposal Proposal(const std::string& modulus = "127 kPa") const {
    const cv::Rect box(cv::Point(305, 80), cv::Point(335, 124));
    std::ostringstream scene;
    std::istringstream lines(slave_->Describe().setup_camera);
    scene << "name: my-block\nobject:\n  geometry:\n"
             "    rectangle: {width: 88 mm, height: 88 mm, thickness: 9 mm}\n"
             "  material: {young_modulus: "
          << modulus
          << ", poisson_ratio: 0.49}\n  fixed: {side: bottom}\n"
             "tool: {shape: flat, width: 5.87 mm, depth: whole}\nmanipulator: none\nsense:\n  "
             "camera:\n";
    for (std::string line; std::getline(lines, line);) scene << "    " << line << "\n";
    scene << "    pixel: 0.35 mm\n    pose: {translation: [44 mm, 54 mm, 0]}\n"
             "  tip: {track: template, template: tip.png, anchor: ["
          << kTip.x() - box.x << ", " << kTip.y() - box.y
          << "]}\n  contour: {track: snake}\n"
             "model: {kind: bem2d, plane: stress, elements: 60}\n";
    return {scene.str(), {{"tip.png", EncodePng(first_(box))}}};
  }

  inline static PrivateFolder* folder_ = nullptr;
  inline static std::map<std::uint64_t, double> true_force_;  // true force by image number [N]
  inline static cv::Mat first_;
  const Scratch saved_;
  // Starts the next slave as `serve` does.
  void Use(const SceneProposal& proposal) {
    session_.Prepare(proposal, nullptr)->Use();
    std::unique_ptr<LiveSlave> next = session_.Next({});
    next->ContinueRevisions(slave_->Describe().settings_revision);
    slave_ = std::move(next);
  }

  SetupSession session_{saved_.path() / "scenes",
                        NamedCamera((folder_->path() / "images").string(), 30)};
  std::unique_ptr<LiveSlave> slave_ = session_.First();
};

TEST_F(SetupSessionTest, WithoutASceneItShowsImagesAndEstimatesNothing) {
  Slave& slave = *slave_;
  EXPECT_EQ(slave.Status().phase, Phase::kSetup);
  EXPECT_EQ(slave.Compose(Clock::now()).phase, Phase::kSetup);
  EXPECT_FALSE(slave.Compose(Clock::now()).force);
  const auto image = slave.Image(false, 80);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->width, 640);
  EXPECT_EQ(slave.Describe().scene.name, "");
  EXPECT_THAT(slave.Describe().setup_camera, HasSubstr("size: [640, 480]"));
}

TEST_F(SetupSessionTest, AMistakeIsNamedWithKeyValueAndWhatIsExpectedAndChangesNothing) {
  const SceneProposal wrong = Proposal("-127 kPa");
  const ProposalReport report = session_.Check(wrong, nullptr);
  ASSERT_EQ(report.mistakes.size(), 1U);
  const SceneMistake& mistake = report.mistakes.front();
  EXPECT_EQ(mistake.key, "object.material.young_modulus");
  EXPECT_EQ(mistake.value, "-127 kPa");
  EXPECT_EQ(mistake.line, 5);
  EXPECT_THAT(mistake.expected, HasSubstr("> 0"));
  EXPECT_THROW(session_.Prepare(wrong, nullptr), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(saved_.path() / "scenes/scene.yaml"));
  EXPECT_EQ(slave_->Status().phase, Phase::kSetup);
}

// A scale that is wrong by a tenth, which only the image can show.
TEST_F(SetupSessionTest, AMistakeInTheImageIsNamedByItsKey) {
  SceneProposal wrong = Proposal();
  const std::string right = "pixel: 0.35 mm";
  wrong.scene.replace(wrong.scene.find(right), right.size(), "pixel: 0.32 mm");
  const ProposalReport report = session_.Check(wrong, nullptr);
  ASSERT_EQ(report.mistakes.size(), 1U);
  EXPECT_EQ(report.mistakes.front().key, "object.geometry");
  EXPECT_THAT(report.mistakes.front().message, HasSubstr("smaller than in the scene"));
}

// Reference: the tool's width and end in the painted image.
TEST_F(SetupSessionTest, AToolThatIsNotTheOneInTheImageIsNamed) {
  const auto changed = [&](const std::string& from, const std::string& to) {
    SceneProposal wrong = Proposal();
    wrong.scene.replace(wrong.scene.find(from), from.size(), to);
    const ProposalReport report = session_.Check(wrong, nullptr);
    return report.mistakes.empty() ? SceneMistake{} : report.mistakes.front();
  };
  const SceneMistake width = changed("width: 5.87 mm", "width: 9 mm");
  EXPECT_EQ(width.key, "tool.width");
  EXPECT_THAT(width.expected, HasSubstr("5.8"));
  const SceneMistake anchor = changed("anchor: [14.5, ", "anchor: [17.5, ");
  EXPECT_EQ(anchor.key, "sense.tip.anchor");
  EXPECT_THAT(anchor.expected, testing::ContainsRegex("-(2.[89]|3.[01]) px to the right"));
  // A tip that is stated less exactly may lie farther from the end, along the tool.
  std::ostringstream stated;
  stated << kTip.y() - 80 << "]}";
  const auto higher = [&](double tolerance) {
    std::ostringstream shifted;
    shifted << kTip.y() - 80 - 2 << "], anchor_tolerance: " << tolerance << " px}";
    return changed(stated.str(), shifted.str()).key;
  };
  EXPECT_EQ(higher(0.3), "sense.tip.anchor");
  EXPECT_EQ(higher(0.7), "");
}

TEST_F(SetupSessionTest, OtherCamerasFoldersAndFilesAreRefused) {
  SceneProposal foreign = Proposal();
  const std::size_t file = foreign.scene.find("file: ");
  foreign.scene.replace(file, foreign.scene.find('\n', file) - file, "url: \"x ! appsink\"");
  const ProposalReport report = session_.Check(foreign, nullptr);
  ASSERT_FALSE(report.mistakes.empty());
  EXPECT_EQ(report.mistakes.front().key, "sense.camera");

  SceneProposal outside = Proposal();
  std::ofstream(saved_.path() / "tip.png", std::ios::binary) << outside.files["tip.png"];
  const std::string name = "template: tip.png";
  outside.scene.replace(outside.scene.find(name), name.size(),
                        "template: " + (saved_.path() / "tip.png").string());
  const ProposalReport read = session_.Check(outside, nullptr);
  ASSERT_EQ(read.mistakes.size(), 1U);
  EXPECT_THAT(read.mistakes.front().message, HasSubstr("outside the proposal"));

  SceneProposal climbing = Proposal();
  climbing.files["../tip.png"] = "";
  EXPECT_THROW(session_.Check(climbing, nullptr), std::invalid_argument);
}

// A file of 0.1 MB that would take 60 MB as pixels.
TEST_F(SetupSessionTest, AnImageOfAnyNameIsBoundedBeforeItIsDecoded) {
  const std::string large = EncodePng(cv::Mat(6000, 5000, CV_16UC1, cv::Scalar(0)));
  for (const char* name : {"image.jpg", "outline.csv", "lens.yaml", "tip.png"}) {
    SceneProposal proposal = Proposal();
    proposal.files[name] = large;
    EXPECT_THROW(session_.Check(proposal, nullptr), std::invalid_argument) << name;
  }
}

TEST_F(SetupSessionTest, AModelThatTakesTooMuchMemoryIsRefused) {
  SceneProposal proposal = Proposal();
  proposal.scene.replace(proposal.scene.find("elements: 60"), 12, "elements: 4000");
  const ProposalReport report = session_.Check(proposal, nullptr);
  ASSERT_EQ(report.mistakes.size(), 1U);
  EXPECT_EQ(report.mistakes.front().key, "model.elements");
}

// Three scenes follow each other. Each is loaded by the name given in the guide.
TEST_F(SetupSessionTest, TheSceneBeforeIsKept) {
  const auto folder = saved_.path() / "scenes", file = folder / "scene.yaml";
  Use(Proposal("101 kPa"));
  const auto modulus = [](const std::filesystem::path& scene) {
    return LoadScene(scene).object.material.young_modulus;
  };
  double last = 101e3;
  for (const char* next : {"102 kPa", "103 kPa", "104 kPa"}) {
    (void)session_.Prepare(Proposal("999 kPa"), nullptr);
    EXPECT_EQ(modulus(file), last) << "it was prepared and not used";
    Use(Proposal(next));
    EXPECT_EQ(modulus(folder / "palpate-scenes/last/scene.yaml"), last);
    last += 1e3;
    EXPECT_EQ(modulus(file), last);
  }
  EXPECT_EQ(session_.First()->Describe().scene.object.material.young_modulus, last);
  std::size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "palpate-scenes")) {
    kept += entry.is_directory() && !entry.is_symlink() ? 1 : 0;
  }
  EXPECT_EQ(kept, 2U);
}

// Accepted and rejected scenes in a folder whose files have the names that a set-up uses.
TEST_F(SetupSessionTest, NoFileOfTheUserIsChanged) {
  const auto folder = saved_.path() / "scenes";
  const std::vector<std::filesystem::path> mine{
      "scene.yaml",          "tip.png",           "outline.csv", "lens.yaml", "image.jpg",
      "scenes/7/thesis.csv", "scenes/last/a.txt", "notes.txt"};
  for (const auto& name : mine) {
    std::filesystem::create_directories((folder / name).parent_path());
    WriteWholeFile(folder / name, "mine: " + name.string());
  }
  WriteWholeFile(folder / "palpate-scenes/mine.txt", "mine");
  for (int i = 0; i < 25; ++i) {
    EXPECT_THROW((void)session_.Prepare(Proposal("abc"), nullptr), std::invalid_argument);
    Use(Proposal(std::to_string(101 + i) + " kPa"));
    WriteWholeFile(folder / "palpate-scenes/current/mine.txt", "mine");
  }
  for (const auto& name : mine) {
    const auto file = folder / name;
    EXPECT_FALSE(std::filesystem::is_symlink(file)) << file;
    EXPECT_EQ(ReadWholeFile(file, 100, "a file"), "mine: " + name.string());
  }
  EXPECT_EQ(ReadWholeFile(folder / "palpate-scenes/mine.txt", 100, "a file"), "mine");
  for (int i = 1; i <= 25; ++i) {
    EXPECT_EQ(
        ReadWholeFile(folder / "palpate-scenes" / std::to_string(i) / "mine.txt", 100, "a file"),
        "mine");
  }
  EXPECT_EQ(session_.First()->Describe().scene.object.material.young_modulus, 125e3);
}

TEST(SavedScenesTest, AFolderThatSomebodyElseMadeIsRefused) {
  const PrivateFolder folder;
  std::filesystem::create_directory(folder.path() / "palpate-scenes");
  WriteWholeFile(folder.path() / "palpate-scenes/thesis.csv", "1");
  EXPECT_THROW(SavedScenes(folder.path()), std::runtime_error);
}

TEST_F(SetupSessionTest, ASceneOfAnotherCameraIsNotServed) {
  SceneProposal other = Proposal();
  const std::size_t size = other.scene.find("rate: 30 Hz");
  other.scene.replace(size, 11, "rate: 20 Hz");
  WriteProposal(other, saved_.path() / "scenes");
  EXPECT_EQ(session_.First()->Status().phase, Phase::kSetup);
}

class Stopped final : public Progress {
 public:
  Stopped() { source_.request_stop(); }
  [[nodiscard]] std::stop_token stop() const override { return source_.get_token(); }

 private:
  std::stop_source source_;
};

TEST_F(SetupSessionTest, AStopIsNoMistakeOfTheScene) {
  Stopped stopped;
  EXPECT_THROW(session_.Check(Proposal(), &stopped), Interrupted);
  EXPECT_THROW(session_.Prepare(Proposal(), &stopped), Interrupted);
  EXPECT_THROW(session_.FindBoard({{}, 9, 6, 5e-3}, &stopped), std::runtime_error);
}

// Reference: distances and focal length of the data's own calibration. The board of the last image
// is tilted, so its pixel size is only near distance / focal length.
TEST_F(SetupSessionTest, ABoardGivesPixelSizeAndLens) {
  const std::filesystem::path chess = SourcePath("/../shared/data/stereo_chessboard_opencv");
  if (!std::filesystem::exists(chess)) GTEST_SKIP() << "../shared is absent";
  BoardImages board{{}, 9, 6, 0.025};
  for (int i = 1; i <= 9; ++i) {
    board.images.push_back(
        ReadWholeFile(chess / ("left0" + std::to_string(i) + ".jpg"), 1 << 20, "an image"));
  }
  const FoundBoard found = session_.FindBoard(board, nullptr);
  EXPECT_EQ(found.corners.size(), 54U);
  EXPECT_THAT(found.lens, HasSubstr("distortion_coefficients"));
  EXPECT_EQ(found.straight.cols, 640);
  EXPECT_EQ(found.remark, "");
  const FoundBoard alone = session_.FindBoard({{board.images.back()}, 9, 6, 0.025}, nullptr);
  EXPECT_EQ(alone.lens, "");
  EXPECT_THAT(alone.remark, HasSubstr("1 images or pairs show the board: expected 3 or more"));
  for (const FoundBoard* each : {&found, &alone}) {
    EXPECT_GT(each->pixel, 0.27 / 533);  // the boards are 277 to 398 mm away
    EXPECT_LT(each->pixel, 0.45 / 533);
  }
  EXPECT_THROW(session_.FindBoard({{board.images.back()}, 8, 5, 0.025}, nullptr),
               std::runtime_error);
}

// Reference: the simulator's finite elements, which the estimator does not know. Tolerance: 60
// elements are 3 to 8 % low.
TEST_F(SetupSessionTest, AGoodSceneIsCheckedSavedUsedAndGivesTheForcesOfTheSavedOne) {
  const ProposalReport report = session_.Check(Proposal(), nullptr);
  ASSERT_TRUE(report.mistakes.empty()) << report.mistakes.front().message;
  EXPECT_THAT(report.text, HasSubstr("my-block (scene.yaml)"));
  EXPECT_THAT(report.text, HasSubstr("found in the image at the start"));
  ASSERT_TRUE(report.contact);
  EXPECT_GT(report.contact->force, 0);
  EXPECT_GT(report.contact->largest_depth, 0);
  EXPECT_EQ(slave_->Status().phase, Phase::kSetup) << "a check changes nothing";

  const auto revision = slave_->Describe().settings_revision;
  Use(Proposal());
  Slave& slave = *slave_;
  EXPECT_EQ(slave.Status().phase, Phase::kObserving);
  EXPECT_EQ(slave.Describe().scene.name, "my-block");
  EXPECT_GT(slave.Describe().settings_revision, revision);
  std::map<std::uint64_t, double> force;
  const auto last = true_force_.rbegin()->first;
  ASSERT_TRUE(Eventually([&] {
    const SlaveState state = slave.Compose(Clock::now());
    EXPECT_EQ(state.phase, Phase::kObserving);
    if (state.force && state.sample > 0) force[state.sample] = state.force->y();
    return state.sample > last;  // the images repeat
  }));

  const DrivenClock clock;
  CameraSense saved(LoadScene(saved_.path() / "scenes/scene.yaml"));
  double peak = 0, true_peak = 0;
  while (saved.Acquire({})) {
    saved.Process();
    const ContactEstimate& estimate = saved.Estimate({});
    ASSERT_TRUE(estimate.force) << estimate.sample;
    EXPECT_EQ(estimate.validity, Validity::kValid) << estimate.sample << ": " << estimate.reason;
    if (force.contains(estimate.sample)) {
      EXPECT_EQ(force[estimate.sample], estimate.force->y()) << estimate.sample;
    }
    peak = std::max(peak, estimate.force->y());
    true_peak = std::max(true_peak, true_force_[estimate.sample]);
  }
  EXPECT_GT(force.size(), true_force_.size() / 4);
  EXPECT_GT(true_peak, 0.5);
  EXPECT_NEAR(peak / true_peak, 1, 0.1);
}

// Encoders that are 5 mm off are not checked; with a manipulator they are.
TEST_F(SetupSessionTest, WithoutAManipulatorTheForcesAreTheSameAndNoEncoderIsCompared) {
  const auto folder = saved_.path() / "scenes";
  Use(Proposal());
  const std::filesystem::path file = folder / "scene.yaml";
  const TipReading wrong{{0.049, 0.094, 0}, std::nullopt};
  const DrivenClock clock;
  const auto none = MakeSensingPipeline(LoadScene(file));
  const auto simulated = MakeSensingPipeline(LoadScene(file, {"manipulator={source: simulated}"}));
  while (none->Acquire({}) && simulated->Acquire({})) {
    none->Process(), simulated->Process();
    const ContactEstimate& estimate = none->Estimate(wrong);
    ASSERT_TRUE(estimate.force);
    EXPECT_EQ(estimate.validity, Validity::kValid) << estimate.reason;
    EXPECT_EQ(*estimate.force, *simulated->Estimate(wrong).force);
  }
  EXPECT_THROW(LoadScene(file, {"sense.tip={track: template}"}), SceneError)
      << "nothing reports where the tip is";
}

TEST(SceneMistakesTest, AMessageIsSplitAtItsKey) {
  const auto is = [](const std::string& message, const char* key, const char* value,
                     const char* text, const char* expected) {
    const SceneMistake mistake = MistakeIn(message);
    EXPECT_EQ(mistake.key, key) << message;
    EXPECT_EQ(mistake.value, value) << message;
    EXPECT_EQ(mistake.message, text) << message;
    EXPECT_EQ(mistake.expected, expected) << message;
  };
  is("camera.size = [640, 480]: expected [320, 240], or no size", "sense.camera.size", "[640, 480]",
     "not accepted", "[320, 240], or no size");
  is("model.kind = x: none: expected a kind", "model.kind", "x", "none", "a kind");
  is("object.geometry: smaller: check it", "object.geometry", "", "smaller: check it", "");
  is("no tip: see sense.tip.anchor.", "sense.tip.anchor", "", "no tip: see sense.tip.anchor.", "");
  is("no tip: see sense.tip.anchor, please", "sense.tip.anchor", "",
     "no tip: see sense.tip.anchor, please", "");
  is("the lens sees nothing", "", "", "the lens sees nothing", "");
  const SceneMistake endless = MistakeIn("tool." + std::string(1'000'000, 'a') + ": expected " +
                                         std::string(1'000'000, 'b'));
  EXPECT_LT(endless.key.size() + endless.message.size() + endless.expected.size(), 2000U);
}

// From four clicks that are 2 px off; reference: the numbers of the scene.
TEST_F(SetupSessionTest, ClicksNearTheCornersAreMovedOntoThem) {
  const std::vector<Vector2d> corners{kLowerLeft, kLowerLeft + Vector2d(kSquareSide, 0),
                                      kLowerLeft + Vector2d(kSquareSide, -kSquareSide),
                                      kLowerLeft + Vector2d(0, -kSquareSide)};
  const std::vector<Vector2d> off{{2, 1}, {-1, 2}, {2, -1}, {-2, -1}};
  Curve near;
  for (std::size_t i = 0; i < 4; ++i) near.push_back(corners[i] + off[i]);
  const FoundOutline found = FindOutlineNear(first_, near);
  EXPECT_GT(found.clear, 0.8);
  for (const Vector2d& corner : corners) {
    double nearest = 100;
    for (const Vector2d& p : found.polygon) nearest = std::min(nearest, (p - corner).norm());
    EXPECT_LT(nearest, 0.3);
  }
  EXPECT_EQ(found.polygon.size(), 4U);
  EXPECT_THROW(FindOutlineNear(first_, CurveView(near).first(2)), std::invalid_argument);
  std::swap(near[0], near[1]);
  EXPECT_THROW(FindOutlineNear(first_, near), std::invalid_argument) << "its sides cross";
  for (const cv::Size size : {cv::Size(20'000, 100), cv::Size(3, 3), cv::Size(640, 1)}) {
    const cv::Mat thin(size, CV_8UC1, cv::Scalar(90));
    EXPECT_THROW(FindOutlineNear(thin, {}), std::runtime_error) << size;
  }
}

}  // namespace
}  // namespace palpate

#include "slave/commands/evaluate/evaluate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <variant>

#include "shared/state/driven_clock.h"
#include "shared/text/text.h"
#include "slave/capture/tactile_recording.h"
#include "slave/commands/progress_bar.h"
#include "slave/commands/scene_remarks.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/scene/scene_loader.h"
#include "slave/solve/solve_rows.h"
#include "slave/study/shape/score_text.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate {
namespace {

std::vector<Contact> ContactsOf(const std::vector<SolveRow>& rows) {
  std::vector<Contact> contacts;
  for (const SolveRow& row : rows) {
    contacts.push_back(row.contact);
    contacts.back().wants_stiffness = false;
  }
  return contacts;
}

std::vector<Eigen::Vector3d> Displacement(const Scene& scene, const ObjectMesh& mesh,
                                          const std::vector<SolveRow>& rows, Progress* progress) {
  const auto model = MakeModel(scene, mesh, progress);
  const std::vector<Contact> contacts = ContactsOf(rows);
  Solution solution;
  model->Reset();
  model->Prefetch(contacts);
  const bool round = std::ranges::any_of(rows, IsPressedRound) && !ShapesTool(scene);
  if (round && rows.size() > 1) {
    throw std::invalid_argument("a round tool together with other rows: expected one row");
  }
  ContactResponse response;
  if (round) {
    ToolPress press(scene, rows.front().tool, mesh);
    response = press.Press(contacts.front(), model.get(), &solution);
  } else {
    model->Solve(contacts, &solution);
    response = solution.responses().front();
  }
  if (response.validity == Validity::kFailed) {
    throw std::invalid_argument("the model has no solution for the tables: " +
                                std::string(model->failure()));
  }
  std::vector<Eigen::Vector3d> displacement;
  model->Displacements(solution, &displacement);
  return displacement;
}

// Computes the surface at the end of the scene's tactile recording from the fingertips' forces; at
// rest if the scene has no recording or no poses. Throws what OpenTactileRecording and
// TactileEstimator throw; Interrupted.
study::EstimatedShape ShapeAfterRecording(const Scene& scene, Progress* progress) {
  study::EstimatedShape shape = ShapeUnderTables(scene, {}, {}, nullptr);
  const auto* tactile = scene.sense.Find<Tactile>();
  if (!tactile || tactile->source != Tactile::Source::kRecording) return shape;
  const DrivenClock clock;
  const auto source = OpenTactileRecording(scene);
  TactileEstimator estimator(scene);
  while (const auto frame = source->Next({})) {
    estimator.Estimate(*frame, scene.manipulator.home);
    if (progress && !progress->Report(source->description(), 0)) throw Interrupted();
  }
  for (int i = 0; i < estimator.finger_count(); ++i) {
    const FingerEstimate& finger = estimator.finger(i);
    if (!finger.has_pose) continue;
    shape.fingers_S.push_back(study::FingerCapsule(finger.X_SF, tactile->finger_radius));
  }
  if (estimator.body() == nullptr) {
    shape.state = "at rest: the scene has no poses of the fingertips";
    return shape;
  }
  shape.estimate_S.triangles = estimator.body()->surface.triangles;
  shape.estimate_S.nodes = estimator.object().DeformedNodes();
  shape.state =
      "the estimate from the fingertips at the end of " + tactile->file.filename().string();
  return shape;
}

// Throws std::invalid_argument `option value: expected ...`.
void Require(bool usable, const char* option, const std::string& value, const char* accepted) {
  if (usable) return;
  throw std::invalid_argument(std::string(option) + " " + value + ": expected " + accepted);
}

study::Segmenting SegmentingOf(const EvaluateOptions& options) {
  if (options.segment == "surfaces") return study::Segmenting::kSurfaces;
  if (options.segment == "colour") return study::Segmenting::kColour;
  Require(options.segment == "no", "--segment", options.segment, "surfaces, colour or no");
  return study::Segmenting::kNone;
}

study::ObjectHint Hint(const EvaluateOptions& options) {
  study::ObjectHint hint;
  if (!options.at.empty()) {
    const Eigen::Vector3d at = Eigen::Map<const Eigen::VectorXd>(
        options.at.data(), static_cast<Eigen::Index>(options.at.size()));
    if (!at.allFinite()) throw std::invalid_argument("--at: expected x,y,z in metres");
    hint.at = at;
  }
  return hint;
}

// Returns why a requested score is missing; empty: it is not.
std::string NotScored(const study::MeasuredQuestion& question,
                      const study::MeasuredAnswer& answer) {
  if (answer.object.empty()) return answer.choice.why;
  if (!question.camera || std::isfinite(answer.score.octree)) return "";
  return "no part of the estimated shape is in view of sense.depth_camera";
}

void PrintAnswer(const study::MeasuredQuestion& question, const study::MeasuredAnswer& answer) {
  std::printf("object: %zu of %zu points, %s\n", answer.object.size(),
              question.measured.cloud->size(), answer.choice.why.c_str());
  if (!question.camera) {
    std::puts("not scored: the scene has no sense.depth_camera");
    return;
  }
  if (!std::isfinite(answer.score.octree)) return;
  std::printf("octree score: %s, %zu simulated points, leaves of %s\n",
              study::Percent(answer.score.octree).c_str(), answer.score.simulated,
              study::Millimetres(question.leaf).c_str());
  std::printf("distance from measured points to the estimate: rms %s, 95 %% %s\n",
              study::Millimetres(answer.score.measured_to_surface.rms).c_str(),
              study::Millimetres(answer.score.measured_to_surface.p95).c_str());
}

void RequireOtherThanInputs(const EvaluateOptions& options, const Scene& scene) {
  std::vector<std::filesystem::path> inputs = InputFilesOf(scene);
  inputs.insert(inputs.end(), {options.cloud, options.contacts, options.loads});
  RequireOtherThan("--out", options.out,
                   {"report.json", "object.pcd", "segmentation.pcd", "simulated.pcd"}, inputs);
}

}  // namespace

study::EstimatedShape ShapeUnderTables(const Scene& scene, const std::filesystem::path& contacts,
                                       const std::filesystem::path& loads, Progress* progress) {
  Scene still = scene;  // the static result, independent of the path
  still.model.fem.time = FemOptions::Time::kStatic;
  still.object = Relaxed(scene.object);
  const ObjectMesh mesh = MeshObject(still, std::nullopt);
  study::EstimatedShape shape;
  shape.rest_S = SurfaceOf(mesh);
  if (shape.rest_S.triangles.empty()) {
    throw std::invalid_argument("object.geometry: evaluate expects a volume: box or mesh");
  }
  shape.estimate_S = shape.rest_S;
  shape.state = "at rest";
  std::vector<SolveRow> rows;
  const RowRules rules = RulesOf(still);
  if (!contacts.empty()) {
    AppendRows(contacts, Contact::Kind::kDisplacement, mesh, rules, &rows);
  }
  if (!loads.empty()) AppendRows(loads, Contact::Kind::kForce, mesh, rules, &rows);
  if (!rows.empty()) {
    shape.state = "the model under " + std::to_string(rows.size()) + " contacts";
    const auto u_O = Displacement(still, mesh, rows, progress);
    for (std::size_t i = 0; i < u_O.size(); ++i) shape.estimate_S.nodes[i] += u_O[i];
  }
  for (SurfaceMesh* surface : {&shape.rest_S, &shape.estimate_S}) {
    for (auto& p : surface->nodes) p = still.object.X_SO * p;
  }
  return shape;
}

int RunEvaluate(const EvaluateOptions& options, const std::stop_token& stop) {
  Require(options.leaf >= 1e-4 && options.leaf <= 1, "--leaf", std::to_string(options.leaf),
          "0.0001 to 1 m");
  study::MeasuredQuestion question;
  question.segmenting = SegmentingOf(options);
  question.hint = Hint(options);
  question.leaf = options.leaf;
  question.measured = study::ReadPcd(options.cloud);
  question.file = options.cloud.filename().string();
  const Scene scene =
      WithChosenModel(LoadScene(options.scene, options.overrides, SceneUse::kSolve));
  LogRemarks(scene);
  RequireOtherThanInputs(options, scene);
  question.scene = scene.name;
  question.camera = scene.sense.depth_camera;
  {
    ProgressBar bar("evaluate", stop);
    const bool tables = !options.contacts.empty() || !options.loads.empty();
    question.shape = tables ? ShapeUnderTables(scene, options.contacts, options.loads, &bar)
                            : ShapeAfterRecording(scene, &bar);
  }
  const study::MeasuredAnswer answer = study::Evaluate(question);
  std::filesystem::create_directories(options.out);
  if (!study::WriteMeasured(question, answer, options.out)) {
    std::fprintf(stderr, "evaluate: %s cannot be written\n", options.out.c_str());
    return 1;
  }
  PrintAnswer(question, answer);
  const std::string why = NotScored(question, answer);
  if (why.empty()) return 0;
  std::fprintf(stderr, "evaluate: %s: no score: %s\n", options.cloud.c_str(), why.c_str());
  return 1;
}

}  // namespace palpate

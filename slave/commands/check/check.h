// `palpate-slave check`: reports the models and checks that will run and why, those that are off,
// and the expected accuracy. Its parts print a label and a sentence, lengths with a readable unit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"
#include "slave/scene/scene_text.h"

namespace palpate {

class Progress;

struct CheckOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  Progress* progress = nullptr;  // of a scene with one camera; null: on the terminal
};

// Prints the report; 0: the scene can run. Throws SceneError, Interrupted and std::exception.
int RunCheck(const CheckOptions& options);

// A contact that a report contains.
struct ReportedContact {
  double depth = 0, force = 0;  // [m], [N]
  double update = 0;            // 99th percentile of the model's update [s]
};
// While it exists, this thread's report is collected instead of printed.
class ReportCollector {
 public:
  ReportCollector();
  ~ReportCollector();
  ReportCollector(const ReportCollector&) = delete;
  ReportCollector& operator=(const ReportCollector&) = delete;
  static ReportCollector* present();  // null: the report is printed

  std::string text;
  std::optional<ReportedContact> contact;
};

// Prints a line as it is.
void PrintText(const std::string& line);

void PrintLine(const std::string& what, const std::string& text);
// Name, object and material.
void PrintObject(const Scene& scene);
std::string InWords(const Camera& camera);
// Prints the source of a stereo pair or depth camera, and when two free-running images are a pair.
void PrintCameras(const Scene& scene);
// Whether live images show a real manipulator.
bool ShowsArm(const Scene& scene);
// Prints the manipulator and the checks that use its encoders.
void PrintManipulator(const Scene& scene);
// Prints which checks of slave/CHECKS.md run.
void PrintChecks(const std::string& which);
// Prints scales, force limit and guards of the operator.
void PrintHand(const Scene& scene);

// Prints the model and the reason for its choice; for `model.kind: auto` also the rejected models
// with their figures.
void PrintChoice(const Scene& scene);

// Prints a contact where the tool would meet the object: force, update time and error as a study
// states them; the error is that of the decision if `auto` made one. Returns the solution of
// `model`, the scene's. `progress`: see CheckOptions.
Solution PrintPress(const Scene& scene, DeformationModel& model, Progress* progress = nullptr);

// Prints time and memory of the model so far; `extruded` prepares each contact position at its
// first query.
void PrintPrecompute(const ModelInfo& info);

// Prints the cost of the deformed shape while a client watches it, measured on a solution.
void PrintShapeCost(DeformationModel& model, const Solution& solution);

// For membranes and volumes: prints the object, its mesh and the mesh quality, the model and a
// contact. Throws std::invalid_argument: the scene cannot be computed.
void PrintBody(const Scene& scene);
// Prints the report of a scene without senses.
void CheckBody(const Scene& scene);

// Prints the report of a scene with a stereo pair or depth images: pose, detected points, accuracy
// and speed. Throws std::invalid_argument or std::runtime_error: the scene cannot be sensed or
// computed.
void CheckStereo(const Scene& scene);

// Prints the report of a scene with fingertips: source, estimates, accuracy and speed. Throws
// std::invalid_argument or std::runtime_error: the scene cannot be sensed or computed.
void CheckTactile(const Scene& scene);

}  // namespace palpate

#include "slave/commands/check/check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include <opencv2/core.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/capture/codecs/codecs.h"
#include "slave/commands/scene_remarks.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/scene/materials.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

void PrintMesh(const BoundaryMesh& mesh) {
  const auto [shortest, longest] =
      std::ranges::minmax_element(mesh.elements, {}, &BoundaryElement::length);
  PrintLine("mesh",
            fmt::format("{} elements in {} loop(s), {} to {} long, ratio {:.2f}", mesh.size(),
                        mesh.loop_begin.size() - 1, LengthInWords(shortest->length()),
                        LengthInWords(longest->length()), longest->length() / shortest->length()));
}

// Prints which motion the window around the tip can follow, and whether the window fits the tool's
// size in the image.
void PrintTip(const Scene& scene) {
  constexpr int kReach = 10;  // smallest margin of the window around the template [px]
  const TipTracking& tip = *scene.sense.Find<TipTracking>();
  const Camera& camera = *scene.sense.Find<Camera>();
  const double width = scene.tool->width / camera.pixel;
  std::string words = fmt::format(
      "{:.3g} px wide, tracked in a window of {} px; its speed may change by {}/s between images",
      width, tip.roi, LengthInWords(kReach * camera.pixel * camera.rate));
  if (tip.template_file.empty() && tip.roi < 2 * kReach + width) {
    words += fmt::format(
        ". ROI IS SMALL: the template is {} px long, less than the tool's width; a tip.roi of "
        "{:.0f} px or more covers its shape",
        std::max(tip.roi - 2 * kReach, 12), std::ceil(2 * kReach + 2 * width));
  }
  PrintLine("tip", words);
}

void PrintModel(const Scene& scene, Progress* progress) {
  PrintChoice(scene);
  if (std::holds_alternative<ImageContourGeometry>(scene.object.geometry)) {
    PrintLine("mesh",
              "generated when the contour is found; conditioning and error are reported then");
    return;
  }
  const BoundaryMesh mesh = MeshOutline(scene, std::nullopt);
  PrintMesh(mesh);
  const std::unique_ptr<DeformationModel> model = MakeModel(scene, mesh, progress);
  const Solution solution = PrintPress(scene, *model, progress);
  PrintPrecompute(model->info());
  PrintShapeCost(*model, solution);
}

// Measures the cost with noise, the slowest kind of image, because the real image is unknown.
void PrintImageCost(const Camera& camera) {
  constexpr int kRepeats = 5, kQuality = 80;
  cv::Mat noise(camera.size[1], camera.size[0], CV_8UC1);
  cv::randu(noise, 0, 255);
  std::size_t bytes = 0;
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kRepeats; ++i) bytes = EncodeJpeg(noise, kQuality).size();
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - began;
  PrintLine("on demand", fmt::format("an image (WatchImages): at most {:.2g} ms and {} kB each",
                                     spent.count() / kRepeats, bytes / 1000));
}

void PrintOff(const Scene& scene) {
  PrintLine("off", "tactile sensing, stereo, volume models: not in this scene");
  if (!scene.sense.Find<ContourTracking>()) {
    PrintLine("off", "contour: the object pose comes from the scene, not from the image");
  }
  const Camera& camera = *scene.sense.Find<Camera>();
  if (camera.size[0] > 0 && camera.size[1] > 0) PrintImageCost(camera);
  const bool is_film =
      camera.source == Camera::Source::kFiles || camera.source == Camera::Source::kVideo;
  if (is_film || camera.source == Camera::Source::kStream) return;
  PrintLine("on demand", fmt::format("all {:g} images per second are processed; two per second "
                                     "while no client reads states or records",
                                     camera.rate));
}

thread_local ReportCollector* collector = nullptr;

}  // namespace

ReportCollector::ReportCollector() {
  collector = this;
}

ReportCollector::~ReportCollector() {
  collector = nullptr;
}

ReportCollector* ReportCollector::present() {
  return collector;
}

void PrintText(const std::string& line) {
  if (collector != nullptr) {
    collector->text += line + "\n";
    return;
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);  // the next step may take long
}

void PrintLine(const std::string& what, const std::string& text) {
  PrintText(fmt::format("  {:<14} {}", what, text));
}

void PrintChecks(const std::string& which) {
  PrintLine("checks",
            which + "; slave/CHECKS.md lists what they flag, compensate and do not detect");
}

void PrintHand(const Scene& scene) {
  if (scene.manipulator.source == ManipulatorOptions::Source::kNone) return;
  PrintLine("operator", fmt::format("position scale {:g}, force scale {:g}, force limit {:g} N",
                                    scene.operator_options.transform.position_scale,
                                    scene.operator_options.transform.force_scale,
                                    scene.operator_options.force_limit));
  const ManipulatorOptions& arm = scene.manipulator;
  const std::string missing = MissingGuards(arm);
  if (!missing.empty()) return PrintLine("UNGUARDED", missing);
  PrintLine("guards", fmt::format("force {:g} N, depth {}: beyond these the tool {}",
                                  arm.force_guard, LengthInWords(arm.depth_guard),
                                  arm.guard_retracts ? "retracts to the surface" : "holds"));
}

void PrintObject(const Scene& scene) {
  const Material& m = scene.object.material;
  PrintText(fmt::format("{} ({})", scene.name, scene.file.string()));
  PrintLine("object", InWords(scene.object.geometry));
  PrintLine("material", fmt::format("E = {:.4g} Pa, nu = {:g}{}", m.young_modulus, m.poisson_ratio,
                                    m.density > 0 ? fmt::format(", {:g} kg/m^3", m.density) : ""));
  for (const auto& [share, time] : m.relaxation) {
    PrintLine("relaxation", fmt::format("{:g} of E fades in {:g} s", share, time));
  }
  for (const Region& region : scene.object.regions) PrintLine("region", InWords(region));
}

void PrintChoice(const Scene& scene) {
  const ModelChoice choice = ChooseModel(scene);
  PrintLine("model", choice.model.kind + ": " + choice.reason);
}

// Prints the named material, its interval and its source.
void PrintNamedMaterial(const CheckOptions& options, const Material& material) {
  const NamedMaterial* named = MaterialOfScene(options.scene, options.overrides);
  if (named == nullptr) return;
  const double E = material.young_modulus, sigma = material.young_modulus_tolerance;
  PrintLine("named", fmt::format("{}: E = {:.4g} Pa, {:.4g} to {:.4g} Pa within one standard "
                                 "deviation",
                                 named->name, E, E * (1 - sigma), E * (1 + sigma)));
  PrintLine("source", std::string(named->source));
}

int RunCheck(const CheckOptions& options) {
  // Membranes and volumes need no senses.
  const Scene body = LoadScene(options.scene, options.overrides, SceneUse::kSolve);
  PrintNamedMaterial(options, body.object.material);
  if (body.sense.Find<Tactile>()) {
    CheckTactile(LoadRunningScene(options.scene, options.overrides));
    return 0;
  }
  if (HasStereoOrDepth(body.sense)) {
    CheckStereo(LoadRunningScene(options.scene, options.overrides));
    return 0;
  }
  const bool is_model_only = !body.sense.Find<Camera>() && !body.sense.Find<TipTracking>();
  if (!IsPlanar(body.object.geometry) || is_model_only) {
    CheckBody(LoadRunningScene(options.scene, options.overrides, SceneUse::kSolve));
    return 0;
  }
  const Scene scene = LoadRunningScene(options.scene, options.overrides);
  PrintObject(scene);
  PrintLine("tool", fmt::format("{}, {} wide", WordOf(scene.tool->shape),
                                LengthInWords(scene.tool->width)));
  const Camera& camera = *scene.sense.Find<Camera>();
  const std::string lens =
      camera.lens.empty() ? ""
                          : ", undistorted with the lens of " + camera.lens.filename().string();
  PrintLine("camera", fmt::format("{}, {:g} Hz, {} per pixel{}", InWords(camera), camera.rate,
                                  LengthInWords(camera.pixel), lens));
  PrintManipulator(scene);
  PrintTip(scene);
  PrintChecks(scene.sense.Find<ContourTracking>()
                  ? "of one camera"
                  : "of one camera, without those of the object's edge: sense.contour adds them");
  PrintHand(scene);
  PrintModel(scene, options.progress);
  PrintOff(scene);
  return 0;
}

}  // namespace palpate

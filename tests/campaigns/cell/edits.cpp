#include "tests/campaigns/cell/edits.h"

#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <variant>

#include <Eigen/Geometry>

namespace palpate::campaign {
namespace {

using Eigen::Vector3d;

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Scales the object's outline about its centre.
void Scale(double factor, Geometry* geometry) {
  if (auto* box = std::get_if<RectangleGeometry>(geometry)) {
    box->width *= factor;
    box->height *= factor;
  } else if (auto* disc = std::get_if<DiscGeometry>(geometry)) {
    disc->radius *= factor;
  } else if (auto* membrane = std::get_if<MembraneGeometry>(geometry)) {
    membrane->radius *= factor;
  }
}

// Names end in what is done with the value; angles in degrees, lengths in metres.
const std::map<std::string, std::function<void(Scene&, double)>>& Edits() {
  static const std::map<std::string, std::function<void(Scene&, double)>> edits{
      {"young_modulus =", [](Scene& scene, double v) { scene.object.material.young_modulus = v; }},
      {"young_modulus *", [](Scene& scene, double v) { scene.object.material.young_modulus *= v; }},
      {"young_modulus_tolerance =",
       [](Scene& scene, double v) { scene.object.material.young_modulus_tolerance = v; }},
      {"prestress =", [](Scene& scene, double v) { scene.model.prestress = v; }},
      {"prestress *", [](Scene& scene, double v) { scene.model.prestress *= v; }},
      {"outline *", [](Scene& scene, double v) { Scale(v, &scene.object.geometry); }},
      {"object x +", [](Scene& scene, double v) { scene.object.X_SO.translation().x() += v; }},
      {"object turn",
       [](Scene& scene, double v) {
         scene.object.X_SO.rotate(Eigen::AngleAxisd(Radians(v), Vector3d::UnitZ()));
       }},
      {"tool width *", [](Scene& scene, double v) { scene.tool->width *= v; }},
      {"tool turn",
       [](Scene& scene, double v) {
         scene.tool->direction = Eigen::Rotation2Dd(Radians(v)) * scene.tool->direction;
       }},
      {"pixel *", [](Scene& scene, double v) { scene.sense.Find<Camera>()->pixel *= v; }},
      {"camera turn",
       [](Scene& scene, double v) {
         scene.sense.Find<Camera>()->X_SC.rotate(Eigen::AngleAxisd(Radians(v), Vector3d::UnitZ()));
       }},
      {"baseline *",
       [](Scene& scene, double v) { scene.sense.Find<StereoCameras>()->baseline *= v; }},
      {"focal *", [](Scene& scene, double v) { scene.sense.Find<StereoCameras>()->focal *= v; }},
      {"rig turn",
       [](Scene& scene, double v) {
         scene.sense.Find<StereoCameras>()->X_SL.rotate(
             Eigen::AngleAxisd(Radians(v), Vector3d::UnitX()));
       }},
      {"rig x +", [](Scene& scene,
                     double v) { scene.sense.Find<StereoCameras>()->X_SL.translation().x() += v; }},
      {"spacing *",
       [](Scene& scene, double v) { scene.sense.Find<PointTracking>()->spacing *= v; }},
  };
  return edits;
}

}  // namespace

void Edit(const nlohmann::json& edits, Scene* scene) {
  for (const nlohmann::json& edit : edits) {
    const auto found = Edits().find(edit.at(0).get<std::string>());
    if (found == Edits().end()) throw std::invalid_argument("no such edit: " + edit.dump());
    found->second(*scene, edit.at(1).get<double>());
  }
}

}  // namespace palpate::campaign

#include "slave/study/planar_truth.h"

#include <cmath>
#include <exception>

#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/true_body.h"

namespace palpate::study {
namespace {

constexpr site::Fineness kCoarse{};
constexpr site::Fineness kFine{
    .largest = 0.1, .growth = 0.25, .at_patch_end = 2e-5, .at_support_end = 1e-4};

double Stiffness(const Scene& scene, const Press& press, double width,
                 const site::Fineness& fineness) {
  const site::TrueBody body(scene);
  const Material& material = scene.object.material;
  const site::PatchSolution solution =
      site::SolvePatch(body, material.poisson_ratio, scene.model.plane,
                       body.Nearest(press.p_O.head<2>()), width, fineness);
  const Eigen::Vector2d way = press.inward_O.head<2>();
  return material.young_modulus * ThicknessOf(scene.object.geometry) *
         way.dot(solution.stiffness * way);
}

}  // namespace

std::optional<Estimate> PlanarStiffness(const Scene& scene, const Press& press, double width) {
  if (!IsPlanar(scene.object.geometry) || scene.model.contact != ContactLaw::kBonded) {
    return std::nullopt;
  }
  try {
    const double fine = Stiffness(scene, press, width, kFine);
    const double coarse = Stiffness(scene, press, width, kCoarse);
    if (!(fine > 0)) return std::nullopt;
    return Estimate{fine, std::abs(fine - coarse)};
  } catch (const std::exception&) {  // the formulation has limits of its own; others remain
    return std::nullopt;
  }
}

}  // namespace palpate::study

#include "slave/commands/identify/press_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLowestPoisson = 0.0, kHighestPoisson = 0.499;
constexpr int kGolden = 22;            // steps of the search for nu: 3e-5
constexpr double kPoissonStep = 5e-3;  // for the curvature of the misfit

struct Press {
  std::vector<Contact> contacts;
  std::vector<Vector3d> forces;
};

// Only what `solve` would accept.
std::vector<Press> ReadPresses(const std::filesystem::path& file, const Scene& scene,
                               double width) {
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const TouchableSurface surface(mesh);
  const double largest = SizeOf(mesh);
  const auto length = Quantity::kLength, force = Quantity::kForce;
  CsvTable rows(file,
                {{"case"},
                 {"x", true, length},
                 {"y", true, length},
                 {"z", false, length},
                 {"dx", true, length},
                 {"dy", true, length},
                 {"dz", false, length},
                 {"fx", true, force},
                 {"fy", true, force},
                 {"fz", false, force},
                 {"width", false, length}},
                CsvTable::Header::kOptional);
  std::vector<Press> presses;
  std::map<std::string, std::size_t, std::less<>> known;
  while (rows.Next()) {
    const auto read = [&](const char* x, const char* y, const char* z) {
      return Vector3d(rows.Number(x), rows.Number(y), rows.Number(z));
    };
    const auto [found, is_new] = known.try_emplace(rows.Text("case"), presses.size());
    if (is_new) presses.emplace_back();
    Press& press = presses[found->second];
    press.contacts.push_back({.p_O = read("x", "y", "z"),
                              .width = rows.IsAbsent("width") ? width : rows.Number("width"),
                              .prescribed_O = read("dx", "dy", "dz")});
    press.forces.push_back(read("fx", "fy", "fz"));
    const Contact& contact = press.contacts.back();
    if (const auto refusal = surface.Refuse(contact.p_O)) rows.Refuse("x", *refusal);
    if (contact.width < 0 || contact.width > largest) {
      rows.Refuse("width", Formatted("0 to %.4g m, the size of the object", largest));
    }
  }
  return presses;
}

VectorXd Stacked(const std::vector<Press>& presses) {
  std::vector<double> all;
  for (const Press& press : presses) {
    for (const Vector3d& f : press.forces) all.insert(all.end(), f.begin(), f.end());
  }
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// Forces of the presses on the scene's object with this nu and the scene's E.
VectorXd Answer(Scene scene, double nu, const std::vector<Press>& presses, PressFit* fit,
                Progress* progress) {
  scene.object.material.poisson_ratio = nu;
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt), progress);
  fit->kind = model->info().kind;
  fit->extrapolated = 0;
  std::vector<double> all;
  std::vector<ContactResponse> responses;
  for (const Press& press : presses) {
    responses.assign(press.contacts.size(), {});
    model->Reset();
    model->Respond(press.contacts, responses);
    if (responses.front().validity == Validity::kFailed) {
      throw std::runtime_error("identify: the model has no solution for a contact: " +
                               std::string(model->failure()));
    }
    if (responses.front().validity != Validity::kValid) ++fit->extrapolated;
    for (const ContactResponse& r : responses) {
      all.insert(all.end(), r.force_O.begin(), r.force_O.end());
    }
  }
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

struct Scale {
  double factor = 0;  // of E
  double misfit = 0;  // squared [N^2]
  double told = 0;    // model's forces squared [N^2]
};

Scale BestScale(const VectorXd& modelled, const VectorXd& measured) {
  const double told = modelled.squaredNorm();
  if (!(told > 0)) throw std::runtime_error("identify: the model's forces are all zero");
  const double factor = modelled.dot(measured) / told;
  return {factor, (factor * modelled - measured).squaredNorm(), told};
}

// Golden section: the misfit has one valley over nu.
double SeekPoisson(const auto& misfit) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double low = kLowestPoisson, high = kHighestPoisson;
  double a = high - ratio * (high - low), b = low + ratio * (high - low);
  double at_a = misfit(a), at_b = misfit(b);
  for (int i = 0; i < kGolden; ++i) {
    if (at_a < at_b) {
      high = b, b = a, at_b = at_a, a = high - ratio * (high - low), at_a = misfit(a);
    } else {
      low = a, a = b, at_a = at_b, b = low + ratio * (high - low), at_b = misfit(b);
    }
  }
  return 0.5 * (low + high);
}

}  // namespace

PressFit FitPress(const Scene& scene, const std::filesystem::path& file, double width,
                  bool seek_poisson, Progress* progress) {
  if (MovesInTime(scene) || !scene.model.fem.gravity_O.isZero(0)) {
    throw std::invalid_argument(
        "press: accepted is a static model without gravity and without material.relaxation, whose "
        "forces are proportional to E");
  }
  if (!scene.object.regions.empty()) {
    throw std::invalid_argument(
        "press: accepted is a body without object.regions, whose forces are proportional to E");
  }
  const std::vector<Press> presses = ReadPresses(file, scene, width);
  const VectorXd measured = Stacked(presses);
  if (!(measured.norm() > 0)) throw InputError(file.string() + ": all forces are zero");
  PressFit fit{.poisson_ratio = scene.object.material.poisson_ratio,
               .sought_poisson = seek_poisson,
               .presses = static_cast<int>(presses.size())};
  const auto scale_at = [&](double nu) {
    return BestScale(Answer(scene, nu, presses, &fit, progress), measured);
  };
  const auto misfit = [&](double nu) { return scale_at(nu).misfit; };
  if (seek_poisson) fit.poisson_ratio = SeekPoisson(misfit);
  const Scale best = scale_at(fit.poisson_ratio);
  if (!(best.factor > 0)) {
    throw InputError(file.string() +
                     ": the forces point away from the displacements: accepted is the force of "
                     "the tool on the object");
  }
  const double E = scene.object.material.young_modulus;
  const auto free = static_cast<double>(std::max<Eigen::Index>(1, measured.size() - 2));
  const double variance = best.misfit / free;
  fit.young_modulus = E * best.factor;
  fit.sigma_modulus = E * std::sqrt(variance / best.told);
  fit.rms = std::sqrt(best.misfit / static_cast<double>(measured.size())) /
            measured.cwiseAbs().maxCoeff();
  if (!seek_poisson) return fit;
  const double inside =
      std::clamp(fit.poisson_ratio, kLowestPoisson + kPoissonStep, kHighestPoisson - kPoissonStep);
  const double curvature =
      (misfit(inside + kPoissonStep) - 2 * misfit(inside) + misfit(inside - kPoissonStep)) /
      (kPoissonStep * kPoissonStep);
  fit.sigma_poisson = curvature > 0 ? std::sqrt(2 * variance / curvature) : 1;
  return fit;
}

}  // namespace palpate

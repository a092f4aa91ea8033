#include "slave/identify/press_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/solve/case_solver.h"
#include "slave/solve/solve_rows.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLowestPoisson = 0.0, kHighestPoisson = 0.499;
constexpr int kGolden = 22;            // steps of the golden-section search for nu; accuracy 3e-5
constexpr double kPoissonStep = 5e-3;  // for the curvature of the misfit

// A press at a point has no limit under refinement: its modulus is that of the mesh.
void RequireWidths(const std::filesystem::path& file, const Scene& scene,
                   const std::vector<SolveRow>& rows) {
  if (std::holds_alternative<MembraneGeometry>(scene.object.geometry)) return;
  const auto point = std::ranges::find_if(rows, [](const SolveRow& row) {
    return row.contact.kind == Contact::Kind::kDisplacement && row.contact.width == 0 &&
           !IsPressedRound(row) && !row.contact.prescribed_O.isZero(0);
  });
  if (point == rows.end()) return;
  throw InputError(file.string() + ": case " + Shown(point->case_name) +
                   ": a contact without a width, whose force depends on the mesh: expected a "
                   "column width or radius, a scene with a tool, or --width");
}

struct Press {
  std::string name;
  std::vector<SolveRow> rows;
};

// Reads the rows as `solve` does with this scene's tool, and their measured responses. `width`: of
// rows without one [m]; 0: the tool's. `remark`: a remark on their positions.
std::vector<Press> ReadPresses(const std::filesystem::path& file, const Scene& scene, double width,
                               Contact::Kind given, std::string* remark) {
  RowRules rules = RulesOf(scene);
  if (width > 0) {
    rules.tool.shape = Tool::Shape::kFlat;
    rules.tool.width = width;
  }
  rules.needs_answers = given == Contact::Kind::kDisplacement;
  rules.has_free_points = !rules.needs_answers;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  std::vector<SolveRow> rows;
  AppendRows(file, given, mesh, rules, &rows);
  if (!rules.shaped) RequireAlone(rows);
  *remark = PlaceRemark(mesh, rows);
  RequireWidths(file, scene, rows);
  std::vector<Press> presses;
  std::map<std::string, std::size_t, std::less<>> known;
  for (SolveRow& row : rows) {
    const auto [found, is_new] = known.try_emplace(row.case_name, presses.size());
    if (is_new) presses.push_back({.name = found->first, .rows = {}});
    presses[found->second].rows.push_back(std::move(row));
  }
  return presses;
}

bool IsFlagged(const SolveRow& row) {
  return row.response.validity != Validity::kValid;
}

VectorXd Stacked(const std::vector<Press>& presses) {
  std::vector<double> all;
  for (const Press& press : presses) {
    for (const SolveRow& row : press.rows) {
      all.insert(all.end(), row.known_O.begin(), row.known_O.end());
    }
  }
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// Forces of the presses, or displacements under the loads, on the scene's object with this nu.
// nullopt: the model has no solution for one of them.
std::optional<VectorXd> Answer(Scene scene, double nu, const std::vector<Press>& presses,
                               PressFit* fit, Progress* progress) {
  scene.object.material.poisson_ratio = nu;
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto model = MakeModel(scene, mesh, progress);
  CaseSolver solver(scene, mesh, model.get());
  fit->kind = model->info().kind;
  fit->extrapolated = 0;
  double errors = 0, squares = 0;
  std::vector<double> all;
  Solution solution;
  for (const Press& press : presses) {
    std::vector<SolveRow> rows = press.rows;
    Case one(rows.size());
    std::iota(one.begin(), one.end(), std::size_t{0});
    if (!solver.Solve(one, CaseStart::kRest, &rows, &solution)) return std::nullopt;
    const auto flagged = std::ranges::find_if(rows, IsFlagged);
    if (flagged != rows.end() && fit->extrapolated++ == 0) fit->flag_reason = ReasonOf(*flagged);
    for (const SolveRow& row : rows) {
      const bool moved = row.contact.kind == Contact::Kind::kDisplacement;
      const Vector3d& found = moved ? row.response.force_O : row.response.displacement_O;
      all.insert(all.end(), found.begin(), found.end());
      errors += ErrorOf(row.response) * found.norm();
      squares += found.squaredNorm();
    }
  }
  fit->model_error = squares > 0 ? errors / squares : 0;
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// The model's error shifts the modulus as a whole, however many presses there are.
void AddModelError(PressFit* fit) {
  fit->sigma_modulus = std::hypot(fit->sigma_modulus, fit->model_error * fit->young_modulus);
}

struct Scale {
  double factor = 0;  // factor on the modelled values
  double misfit = 0;  // squared [N^2], [m^2]
  double modelled_square = 0;
};

Scale BestScale(const VectorXd& modelled, const VectorXd& measured) {
  const double modelled_square = modelled.squaredNorm();
  if (!(modelled_square > 0))
    throw std::runtime_error("identify: the model's answers are all zero");
  const double factor = modelled.dot(measured) / modelled_square;
  return {factor, (factor * modelled - measured).squaredNorm(), modelled_square};
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

void RequireStatic(const Scene& scene, const char* kind) {
  if (MovesInTime(scene)) {
    throw std::invalid_argument(std::string(kind) +
                                ": expected a static model without material.relaxation");
  }
  if (!scene.object.regions.empty()) {
    throw std::invalid_argument(std::string(kind) +
                                ": expected a body without object.regions, of one modulus");
  }
}

// Fits the modulus by Gauss-Newton for an object with tension at rest, whose part of the force is
// independent of the modulus. Starts from the scene's modulus. `by_modulus`: final derivative of
// the forces [N/Pa].
VectorXd FitUnderTension(Scene scene, const std::vector<Press>& presses, const VectorXd& measured,
                         PressFit* fit, VectorXd* by_modulus, Progress* progress) {
  constexpr int kMaxSteps = 30;
  constexpr double kEqual = 1e-6, kVaried = 1e-3, kMaxFactor = 5;
  double& E = scene.object.material.young_modulus;
  const auto forces = [&] {
    auto answer = Answer(scene, fit->poisson_ratio, presses, fit, progress);
    if (!answer) throw std::runtime_error("identify: the model has no solution for a contact");
    return *std::move(answer);
  };
  for (int i = 0; i < kMaxSteps; ++i) {
    const double at = E;
    const VectorXd modelled = forces();
    E = at * (1 + kVaried);
    *by_modulus = (forces() - modelled) / (at * kVaried);
    const double step =
        by_modulus->dot(measured - modelled) / std::max(by_modulus->squaredNorm(), 1e-300);
    E = std::clamp(at + step, at / kMaxFactor, at * kMaxFactor);
    fit->young_modulus = at;
    if (std::abs(E - at) <= kEqual * at) return modelled;
  }
  throw InputError(
      "identify: no modulus fits these forces under model.prestress: expected larger ones, or a "
      "smaller tension");
}

// Scales the scene's modulus until the modelled displacements are as large as the measured ones.
VectorXd ScaleToLoads(Scene scene, const std::vector<Press>& presses, const VectorXd& measured,
                      const std::filesystem::path& file, PressFit* fit, Progress* progress) {
  constexpr int kMaxSteps = 30;
  constexpr double kEqual = 1e-4, kStiffer = 10;
  double& E = scene.object.material.young_modulus;
  for (int i = 0; i < kMaxSteps; ++i) {
    auto modelled = Answer(scene, fit->poisson_ratio, presses, fit, progress);
    fit->young_modulus = E;
    if (!modelled) {  // the weight deforms the body
      E *= kStiffer;
      continue;
    }
    *modelled = measured.array().isNaN().select(0, *modelled);
    const double factor = BestScale(*modelled, measured.array().isNaN().select(0, measured)).factor;
    if (!(factor > 0)) {
      throw InputError(file.string() + ": the displacements point away from gravity and loads");
    }
    if (std::abs(factor - 1) < kEqual) return *modelled;
    E /= factor;
  }
  throw std::runtime_error(
      "identify: no modulus gives displacements as large as the measured ones");
}

}  // namespace

PressFit FitLoads(const Scene& scene, const std::filesystem::path& file, double width,
                  Progress* progress) {
  RequireStatic(scene, "loads");
  PressFit fit{.poisson_ratio = scene.object.material.poisson_ratio};
  const std::vector<Press> presses =
      ReadPresses(file, scene, width, Contact::Kind::kForce, &fit.remark);
  fit.presses = static_cast<int>(presses.size());
  const VectorXd rows = Stacked(presses);
  const VectorXd measured = rows.array().isNaN().select(0, rows);
  if (!(measured.norm() > 0))
    throw InputError(file.string() + ": expected a row with a dx, dy or dz");
  const VectorXd modelled = ScaleToLoads(scene, presses, rows, file, &fit, progress);
  const Scale best = BestScale(modelled, measured);
  const auto count = static_cast<double>(rows.size() - rows.array().isNaN().count());
  fit.sigma_modulus =
      fit.young_modulus * std::sqrt(best.misfit / std::max(1.0, count - 1) / best.modelled_square);
  AddModelError(&fit);
  fit.rms = std::sqrt(best.misfit / count) / measured.cwiseAbs().maxCoeff();
  Eigen::Index at = 0;
  for (const Press& press : presses) {
    const auto size = 3 * static_cast<Eigen::Index>(press.rows.size());
    const Scale own = BestScale(modelled.segment(at, size), measured.segment(at, size));
    fit.alone.emplace_back(press.name, fit.young_modulus / own.factor);
    at += size;
  }
  return fit;
}

PressFit FitPress(const Scene& scene, const std::filesystem::path& file, double width,
                  bool seek_poisson, Progress* progress) {
  RequireStatic(scene, "press");
  if (!scene.model.fem.gravity_O.isZero(0)) {
    throw std::invalid_argument("press: expected a model without gravity");
  }
  PressFit fit{.poisson_ratio = scene.object.material.poisson_ratio,
               .sought_poisson = seek_poisson};
  const std::vector<Press> presses =
      ReadPresses(file, scene, width, Contact::Kind::kDisplacement, &fit.remark);
  fit.presses = static_cast<int>(presses.size());
  const VectorXd measured = Stacked(presses);
  if (!(measured.norm() > 0)) throw InputError(file.string() + ": all forces are zero");
  if (scene.model.prestress > 0) {
    if (seek_poisson) {
      throw std::invalid_argument("press: expected poisson without model.prestress");
    }
    VectorXd by_modulus;
    const VectorXd modelled =
        FitUnderTension(scene, presses, measured, &fit, &by_modulus, progress);
    const double misfit = (modelled - measured).squaredNorm();
    const auto rows = static_cast<double>(measured.size());
    fit.sigma_modulus = std::sqrt(misfit / std::max(1.0, rows - 2) / by_modulus.squaredNorm());
    AddModelError(&fit);
    fit.rms = std::sqrt(misfit / rows) / measured.cwiseAbs().maxCoeff();
    return fit;
  }
  const auto scale_at = [&](double nu) {
    const auto modelled = Answer(scene, nu, presses, &fit, progress);
    if (!modelled) throw std::runtime_error("identify: the model has no solution for a contact");
    return BestScale(*modelled, measured);
  };
  const auto misfit = [&](double nu) { return scale_at(nu).misfit; };
  if (seek_poisson) fit.poisson_ratio = SeekPoisson(misfit);
  const Scale best = scale_at(fit.poisson_ratio);
  if (!(best.factor > 0)) {
    throw InputError(file.string() +
                     ": the forces point away from the displacements: expected the force of "
                     "the tool on the object");
  }
  const double E = scene.object.material.young_modulus;
  const auto free = static_cast<double>(std::max<Eigen::Index>(1, measured.size() - 2));
  const double variance = best.misfit / free;
  fit.young_modulus = E * best.factor;
  fit.sigma_modulus = E * std::sqrt(variance / best.modelled_square);
  AddModelError(&fit);
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

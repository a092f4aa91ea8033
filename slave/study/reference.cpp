#include "slave/study/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "shared/text/text.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/plate/plate_law.h"
#include "slave/reference/planar/patch_solution.h"
#include "slave/reference/planar/round_touch.h"
#include "slave/reference/planar/true_body.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/richardson.h"
#include "slave/study/seen_press.h"
#include "slave/study/volume_force.h"

namespace palpate::study {
namespace {

constexpr simulation::Fineness kRough{
    .largest = 0.25, .growth = 0.6, .at_patch_end = 2e-3, .at_support_end = 2e-3};
constexpr simulation::Fineness kMedium{};
constexpr simulation::Fineness kFine{
    .largest = 0.1, .growth = 0.25, .at_patch_end = 2e-5, .at_support_end = 1e-4};

double Stiffness(const Scene& scene, const Press& press, double width,
                 const simulation::Fineness& fineness) {
  const simulation::TrueBody body(scene);
  const double nu = scene.object.material.poisson_ratio;
  const double unit = scene.object.material.young_modulus * ThicknessOf(scene.object.geometry);
  const simulation::BoundaryPlace place = body.Nearest(press.p_O.head<2>());
  const Eigen::Vector2d way = press.inward_O.head<2>();
  if (scene.model.contact == ContactLaw::kFrictionless) {
    return unit *
           simulation::SlidingStiffness(body, nu, scene.model.plane, place, width, way, fineness);
  }
  const auto bonded = simulation::SolvePatch(body, nu, scene.model.plane, place, width, fineness);
  return unit * way.dot(bonded.stiffness * way);
}

// Force at this depth of a tool whose contact grows with it: a round one, or one on a curved
// outline.
double TouchedForce(const Scene& scene, const Press& press, double width, double depth) {
  const simulation::TrueBody body(scene);
  const auto solution = simulation::SolveUnderRound(
      body, scene.object.material.poisson_ratio, scene.model.plane,
      body.Nearest(press.p_O.head<2>()), scene.tool.value_or(Tool{.width = width}));
  const Eigen::Vector2d way = press.inward_O.head<2>();
  return scene.object.material.young_modulus * ThicknessOf(scene.object.geometry) *
         way.dot(simulation::Touched(*solution.round, depth * way, 0).total());
}

constexpr double kGood = 0.05;  // largest relative uncertainty of an independent answer
// Relative uncertainty of such a contact (round_touch_test).
constexpr double kTouched = 1e-3;

// Whether a bonded tool touches an outline only where the outline reaches it.
bool IsTouchedOutline(const Scene& scene) {
  return IsPlanar(scene.object.geometry) && scene.model.contact == ContactLaw::kBonded &&
         (IsTouchedRound(scene) || std::holds_alternative<DiscGeometry>(scene.object.geometry));
}
// Relative uncertainty of the error of a plate's law, see plate_law.h.
constexpr double kOfLaw = 0.3;
// Relative uncertainty of a nonlinearity that is known from one mesh only.
constexpr double kOneMesh = 0.3;
constexpr const char* kIndependent = "finite elements";

struct Limit {
  std::string kind, words;
  Estimate force;
  bool extrapolated = true;
  double step = 0;  // from the finest answer to the limit [N]
  [[nodiscard]] double relative_bar() const { return force.bar / std::abs(force.value); }
};

// Returns whether the row answered every press. `extruded` answers the first one, and is compared
// with no plane model.
bool AnsweredAllPresses(const StudyRow& row) {
  return row.outcome == Outcome::kAnswered && !IsSolidOutline(row.kind);
}

bool IsLinearAnswer(const StudyRow& row) {
  return AnsweredAllPresses(row) && row.linear;
}

// Two references are independent if their formulations differ. The same elements with another law
// are not independent.
std::string FormulationOf(const StudyRow& row) {
  const ModelKind* kind = FindModelKind(row.kind);
  if (kind == nullptr || !kind->has_tets || row.element_size == 0) return row.kind;
  return row.family.find("tet10") == std::string::npos ? "tet4" : "tet10";
}

// Families in the order of their rows; within a resolution the smallest residual last.
std::map<std::string, std::vector<const StudyRow*>> Families(const std::vector<StudyRow>& rows) {
  std::map<std::string, std::vector<const StudyRow*>> families;
  for (const StudyRow& row : rows) {
    if (!AnsweredAllPresses(row)) continue;
    families[row.family].push_back(&row);
  }
  for (auto& [name, members] : families) {
    std::ranges::stable_sort(members, [](const StudyRow* a, const StudyRow* b) {
      return std::pair(a->element_size, -a->residual) < std::pair(b->element_size, -b->residual);
    });
  }
  return families;
}

std::optional<Limit> LimitOf(const std::vector<const StudyRow*>& members, std::size_t press) {
  const StudyRow& finest = *members.front();
  if (finest.element_size == 0) {
    const double force = members.back()->answers[press].small.value;
    return Limit{FormulationOf(finest), finest.family + " (has no mesh)", {force, 0}, true};
  }
  std::vector<MeshAnswer> answers;
  for (const StudyRow* row : members) {
    const double force = row->answers[press].small.value;
    if (std::isfinite(force)) answers.push_back({row->element_size, force});
  }
  const double nearest = answers.empty() ? kUnknown : answers.front().value;
  const Extrapolation limit = Extrapolate(std::move(answers));
  if (!std::isfinite(limit.limit.value)) return std::nullopt;
  std::string words = finest.family + ", finest " + finest.resolution;
  words += std::isfinite(limit.order) ? Formatted(", extrapolated with order %.2f", limit.order)
                                      : ", not converging smoothly";
  return Limit{FormulationOf(finest), std::move(words), limit.limit, std::isfinite(limit.order),
               std::abs(limit.limit.value - nearest)};
}

// Returns the best independent limit for comparison: of another formulation if there is one, with a
// small uncertainty.
const Limit* SecondOpinion(const std::vector<Limit>& limits, const Limit& best) {
  const Limit* second = nullptr;
  const auto rank = [&](const Limit& l) {
    return std::pair(l.kind == best.kind, l.relative_bar());
  };
  for (const Limit& l : limits) {
    if (&l == &best || !l.extrapolated) continue;
    if (!second || rank(l) < rank(*second)) second = &l;
  }
  return second;
}

// How fine the elements of a reference are: the coarse ones of many presses, those of a single one,
// and those that check both.
enum class Detail : std::uint8_t { kMany, kSingle, kCheck };

// Returns the force at the small depth from finite elements graded for the press, as fine as the
// study's time permits; its bar is NaN if only another mesh tells it. A box is prepared by
// `WithFewCells`.
std::optional<Estimate> Graded(const Scene& scene, const Press& press, const PressSpec& question,
                               Detail detail) {
  const double width = question.width;
  const bool is_usual = !scene.tool || scene.tool->shape == Tool::Shape::kFlat ||
                        scene.tool->shape == Tool::Shape::kRound;
  if (press.loaded || !is_usual || scene.model.contact == ContactLaw::kFriction)
    return std::nullopt;
  if (IsVolume(scene.object.geometry)) {
    constexpr Grading kRoughGrading{0.4, 0.4, 3};
    const bool is_rough = detail == Detail::kMany;
    return VolumeForce(scene, press, width, question.small_depth,
                       is_rough ? kRoughGrading : kFineGrading);
  }
  // The whole width of a sliding tool would take the shape of a curved outline.
  if (std::holds_alternative<DiscGeometry>(scene.object.geometry)) return std::nullopt;
  const PlanarMesh mesh = detail == Detail::kMany     ? PlanarMesh::kRough
                          : detail == Detail::kSingle ? PlanarMesh::kFine
                                                      : PlanarMesh::kMedium;
  const auto stiffness = PlanarStiffness(scene, press, width, mesh);
  if (!stiffness) return std::nullopt;
  return Estimate{*stiffness * question.small_depth, kUnknown};
}

// Returns the scene with as few cells as the far field needs, because they are refined near the
// tool.
Scene WithFewCells(Scene scene, double width) {
  constexpr double kFar = 0.25;  // of the box
  scene.model.refinements = 0;
  auto* box = std::get_if<BoxGeometry>(&scene.object.geometry);
  const auto on_a_side = [&](const Fixed& fixed) {
    const auto* plane = std::get_if<FixedPlane>(&fixed.where);
    if (plane == nullptr) return false;
    const double size = box->size[plane->axis];
    return plane->at * (size - plane->at) <= 1e-9 * size * size;
  };
  if (box == nullptr || !scene.object.regions.empty() ||
      !std::ranges::all_of(scene.object.fixed, on_a_side)) {
    return scene;
  }
  const double edge = std::max(width, kFar * box->size.maxCoeff());
  for (std::size_t k = 0; k < box->cells.size(); ++k) {
    const double size = box->size[static_cast<Eigen::Index>(k)];
    box->cells[k] = std::min(box->cells[k], static_cast<int>(std::ceil(size / edge)));
  }
  return scene;
}

// Returns the error of von Karman's law relative to a solid membrane, which the limits of plate
// models do not show.
double ExcessOfLaw(const MembraneGeometry& membrane, const Press& press, double depth) {
  return plate::ExcessAtDepth({press.p_O.head<2>().norm() / membrane.radius,
                               depth / membrane.radius, membrane.thickness / membrane.radius});
}

// Ratio of the finer to the coarse answers: mean over the checked presses, and spread of single
// ones.
Estimate Finer(const std::vector<double>& ratios) {
  const auto count = static_cast<double>(ratios.size());
  double mean = 0, scatter = 0;
  for (const double ratio : ratios) mean += ratio / count;
  for (const double ratio : ratios) scatter += (ratio - mean) * (ratio - mean);
  const double half_step = 0.5 * std::abs(mean - 1);  // uncertainty of the finer ones
  return {mean, std::max(half_step, std::sqrt(scatter / std::max(count - 1, 1.0)))};
}

// The force at full depth of the linear model of the same kind on the same elements; NaN: none.
// Kinds differ in how few elements touch a tool.
double LinearForce(const std::vector<StudyRow>& rows, const StudyRow& large, std::size_t press) {
  const auto linear = std::ranges::find_if(rows, [&](const StudyRow& row) {
    return IsLinearAnswer(row) && row.element_size == large.element_size &&
           row.kind == large.kind && FormulationOf(row) == FormulationOf(large);
  });
  return linear == rows.end() ? kUnknown : linear->answers[press].full.value;
}

// Returns the ratio of the nonlinear to the linear force at full depth; `linear`: the linear force
// there.
template <typename Linear>
Estimate Stiffening(const std::vector<const StudyRow*>& members, std::size_t press,
                    const Linear& linear) {
  std::vector<MeshAnswer> ratios;
  for (const StudyRow* row : members) {
    const double ratio = row->answers[press].full.value / linear(*row);
    if (std::isfinite(ratio)) ratios.push_back({row->element_size, ratio});
  }
  if (ratios.empty()) return {};
  if (members.front()->element_size == 0) return {ratios.back().value, 0};
  const Estimate limit = Extrapolate(ratios).limit;
  if (std::isfinite(limit.value)) return limit;
  return {ratios.back().value, kOneMesh * std::abs(ratios.back().value - 1)};
}

// PressErrors holds the errors of a row at each press.
struct PressErrors {
  std::vector<Estimate> small, full;
  std::vector<double> deviation;
};

bool IsWorse(double a, double b) {
  return std::isnan(a) ? !std::isnan(b) : a > b;
}

// Returns the largest error of up to nine contacts, or the 90th percentile if there are more,
// because the position of a mesh under one of many contacts is random.
template <typename Value, typename Error>
Value AtNineOfTen(std::vector<Value> all, Error error) {
  std::ranges::sort(all,
                    [&](const Value& a, const Value& b) { return IsWorse(error(a), error(b)); });
  return all[all.size() / 10];
}

// Returns one sigma of the 90th percentile as an estimate for all positions: the number of errors
// beyond it is binomial, which determines the ranks before and after it.
double SamplingBar(std::vector<double> errors) {
  if (errors.size() < kMany) return 0;
  std::ranges::sort(errors, IsWorse);
  const auto last = static_cast<double>(errors.size() - 1), count = last + 1;
  const double rank = std::floor(count / 10), sigma = std::sqrt(0.09 * count);
  const auto at = [&](double r) {
    return errors[static_cast<std::size_t>(std::round(std::clamp(r, 0.0, last)))];
  };
  return 0.5 * std::abs(at(rank - sigma) - at(rank + sigma));
}

void EvaluatePress(const Reference& reference, const PressAnswers& answers, PressErrors* errors) {
  const auto judge = [&](const Estimate& truth, double value) {
    const double bar = std::abs(truth.bar / truth.value);
    const double off = std::abs(value / truth.value - 1);
    return Estimate{off >= 0 ? std::max(off, bar) : kUnknown, bar};
  };
  errors->small.push_back(judge(reference.small, answers.small.value));
  errors->full.push_back(judge(reference.full, answers.full.value));
  errors->deviation.push_back(std::abs(answers.full.value / reference.full.value - 1));
}

}  // namespace

std::size_t BeyondBound(std::size_t count) {
  constexpr double kBeyond = 0.1, kRisk = 0.05;
  const auto n = static_cast<double>(count);
  // Probability of `rank` or fewer places beyond.
  double chance = std::pow(1 - kBeyond, n), risk = chance;
  std::size_t rank = 0;
  for (; rank < count; ++rank) {
    const auto k = static_cast<double>(rank);
    chance *= (n - k) / (k + 1) * kBeyond / (1 - kBeyond);
    risk += chance;
    if (risk > kRisk) break;
  }
  return rank;
}

std::optional<double> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                      PlanarMesh fineness) {
  if (!IsPlanar(scene.object.geometry)) return std::nullopt;
  constexpr std::array kMeshes{kRough, kMedium, kFine};
  // There is no stiffness, because the contact grows.
  if (IsTouchedRound(scene)) return std::nullopt;
  try {
    const double found =
        Stiffness(scene, press, width, kMeshes[static_cast<std::size_t>(fineness)]);
    return found > 0 ? std::optional(found) : std::nullopt;
  } catch (const std::exception&) {  // this formulation is not applicable; others remain
    return std::nullopt;
  }
}

ReferenceFinder::ReferenceFinder(const Scene& scene, const PressSpec& question)
    : question_(question) {
  if (const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry)) {
    membrane_ = *membrane;
  }
  if (!question.seen.empty()) return;
  if (IsTouchedOutline(scene)) {
    AddTouched(scene);
    return;
  }
  constexpr std::size_t kChecked = 3;  // number of checked presses if there are many
  const std::size_t count = question.presses.size();
  const bool many = count >= kMany;
  const Scene few = WithFewCells(scene, question.width);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < count; ++i) {
    const Press& press = question.presses[i];
    const auto force = Graded(few, press, question, many ? Detail::kMany : Detail::kSingle);
    independent_.push_back(force.value_or(Estimate{}));
    if (!force || (many && i % (count / kChecked) != 0)) continue;
    if (!many && std::isfinite(force->bar)) continue;
    const auto other = Graded(few, press, question, Detail::kCheck);
    if (!other) continue;
    ratios.push_back(other->value / force->value);
    if (!many) independent_.back().bar = force->value * std::abs(ratios.back() - 1);
  }
  if (!many || ratios.empty()) return;
  const Estimate finer = Finer(ratios);
  for (Estimate& force : independent_) {
    force = {force.value * finer.value, force.value * finer.bar};
  }
}

void ReferenceFinder::AddTouched(const Scene& scene) {
  for (const Press& press : question_.presses) {
    Estimate force;
    try {
      force.value = TouchedForce(scene, press, question_.width, question_.depth);
      force.bar = kTouched * force.value;
    } catch (const std::exception&) {  // no mesh or position; the limit of the models remains
    }
    independent_.push_back(force);
  }
}

Reference ReferenceFinder::FindOne(const std::vector<StudyRow>& rows, std::size_t press) const {
  if (!question_.seen.empty()) {
    const Estimate force{question_.seen[press].force, kSeenForce * question_.seen[press].force};
    return {force, force, "a hyperelastic solid before the scene's cameras"};
  }
  const auto families = Families(rows);
  std::vector<Limit> limits;
  if (std::isfinite(independent_[press].bar)) {
    limits.push_back({kIndependent, "quadratic finite elements on a mesh graded for the contact",
                      independent_[press], true});
  }
  const bool any_linear = std::ranges::any_of(rows, IsLinearAnswer);
  for (const auto& [name, members] : families) {
    const StudyRow& finest = *members.front();
    if (any_linear && !finest.linear && finest.element_size > 0) continue;
    if (auto limit = LimitOf(members, press)) limits.push_back(*std::move(limit));
  }
  if (limits.empty()) return {{}, {}, "none: too few results to extrapolate"};
  const bool settled = limits.front().kind == kIndependent && limits.front().relative_bar() < kGood;
  const Limit& best =
      settled ? limits.front() : *std::ranges::min_element(limits, {}, [](const Limit& l) {
        return std::pair(!l.extrapolated, l.relative_bar());
      });
  Reference reference{best.force, {}, best.words};
  // An error bar also covers the variation of the mesh's position between contacts.
  if (settled) {
    reference.source += "; not compared with others";
  } else if (const Limit* second = SecondOpinion(limits, best)) {
    const double apart = std::abs(second->force.value - best.force.value);
    // A difference up to the distance of the extrapolation is no contradiction.
    const double own = std::max(second->force.bar, second->step);
    reference.small.bar = std::max(best.force.bar, apart - own);
    reference.source += "; differs from " + second->words +
                        Formatted(" by %.2g %%", 100 * apart / std::abs(best.force.value));
  } else {
    reference.source += "; no other formulation has a solution";
  }

  const double depths = question_.depth / question_.small_depth;
  Estimate stiffening{1, 0};
  for (const auto& [name, members] : families) {
    if (!IsLargeDeformation(members.front()->model)) continue;
    // The contact of a tool on a volume grows with the depth, so its linear force does not show the
    // law.
    const Estimate found = Stiffening(members, press, [&](const StudyRow& row) {
      return membrane_ ? row.answers[press].small.value * depths : LinearForce(rows, row, press);
    });
    if (std::isfinite(found.value)) stiffening = found;
  }
  const double excess =
      membrane_ ? ExcessOfLaw(*membrane_, question_.presses[press], question_.depth) : 0;
  reference.full.value = reference.small.value * depths * stiffening.value / (1 + excess);
  reference.full.bar = reference.full.value * (reference.small.bar / reference.small.value +
                                               stiffening.bar / stiffening.value + kOfLaw * excess);
  return reference;
}

References ReferenceFinder::Find(const std::vector<StudyRow>& rows) const {
  References references;
  for (std::size_t press = 0; press < question_.presses.size(); ++press) {
    references.presses.push_back(FindOne(rows, press));
  }
  const bool any_large = std::ranges::any_of(rows, [](const StudyRow& row) {
    return row.outcome == Outcome::kAnswered && IsLargeDeformation(row.model);
  });
  if (!any_large) {
    references.remark =
        "no model of large deformation has a solution: the errors do not include its effect";
  }
  return references;
}

void EvaluateRows(const References& references, std::vector<StudyRow>* rows) {
  for (StudyRow& row : *rows) {
    if (!AnsweredAllPresses(row)) continue;
    PressErrors errors;
    for (std::size_t i = 0; i < row.answers.size(); ++i) {
      EvaluatePress(references.presses[i], row.answers[i], &errors);
    }
    row.error = AtNineOfTen(errors.full, std::mem_fn(&Estimate::value));
    row.error.bar = std::hypot(row.error.bar, SamplingBar(errors.deviation));
    std::ranges::sort(errors.full, IsWorse, &Estimate::value);
    row.bound = errors.full[BeyondBound(errors.full.size())].value;
    row.error_small = AtNineOfTen(errors.small, std::mem_fn(&Estimate::value));
    row.deviation = AtNineOfTen(errors.deviation, std::identity{});
  }
}

}  // namespace palpate::study

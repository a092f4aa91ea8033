#include "slave/study/reference.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <utility>

#include "shared/text/text.h"
#include "slave/scene/model_kinds.h"
#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/true_body.h"
#include "slave/study/richardson.h"

namespace palpate::study {
namespace {

constexpr site::Fineness kRough{
    .largest = 0.25, .growth = 0.6, .at_patch_end = 2e-3, .at_support_end = 2e-3};
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

constexpr double kOneMesh = 0.3;  // of its own effect: a nonlinearity known from one mesh only
constexpr const char* kIndependent = "finite elements";

struct Limit {
  std::string kind, words;
  Estimate force;
  bool extrapolated = true;
  double step = 0;  // from the finest answer to the limit [N]
  [[nodiscard]] double relative_bar() const { return force.bar / std::abs(force.value); }
};

bool IsLinearAnswer(const StudyRow& row) {
  return row.outcome == Outcome::kAnswered && row.linear;
}

bool IsLarge(const StudyRow& row) {
  const ModelKind* kind = FindModelKind(row.kind);
  return kind != nullptr && kind->linearity == Linearity::kNever;
}

// What two opinions have to differ in to be two: the same elements under another law are not.
std::string FormulationOf(const StudyRow& row) {
  const ModelKind* kind = FindModelKind(row.kind);
  if (kind == nullptr || !kind->has_tets || row.element_size == 0) return row.kind;
  return row.family.find("tet10") == std::string::npos ? "tet4" : "tet10";
}

// Families in the order of their rows; within a resolution the smallest residual last.
std::map<std::string, std::vector<const StudyRow*>> Families(const std::vector<StudyRow>& rows) {
  std::map<std::string, std::vector<const StudyRow*>> families;
  for (const StudyRow& row : rows) {
    if (row.outcome == Outcome::kAnswered) families[row.family].push_back(&row);
  }
  for (auto& [name, members] : families) {
    std::ranges::stable_sort(members, [](const StudyRow* a, const StudyRow* b) {
      return std::pair(a->element_size, -a->residual) < std::pair(b->element_size, -b->residual);
    });
  }
  return families;
}

// d ln force / d ln width: of the finest member that could tell, else of nobody.
double SlopeOf(const std::vector<const StudyRow*>& members, std::size_t press) {
  for (const StudyRow* row : members) {
    const double slope = row->answers[press].width_slope;
    if (std::isfinite(slope)) return slope;
  }
  return 0;
}

// `loaded`: every mesh saw the same load, so nothing is left to correct.
std::optional<Limit> LimitOf(const std::vector<const StudyRow*>& members, std::size_t press,
                             bool loaded) {
  const StudyRow& finest = *members.front();
  if (finest.element_size == 0) {
    const double force = members.back()->answers[press].small.value;
    return Limit{FormulationOf(finest), finest.family + " (has no mesh)", {force, 0}, true};
  }
  const double slope = loaded ? 0 : SlopeOf(members, press);
  std::vector<MeshAnswer> answers;
  for (const StudyRow* row : members) {
    const PressAnswers& a = row->answers[press];
    const double width = loaded ? 1 : 1 + a.width_mismatch;
    if (!(width > 0) || !std::isfinite(a.small.value)) continue;
    answers.push_back({row->element_size, a.small.value * std::pow(width, -slope)});
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

// The nearest thing to a second opinion: of another kind if there is one, of small bar.
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

// How much stiffer than linear the object is at full depth.
Estimate Stiffening(const std::vector<const StudyRow*>& members, std::size_t press, double depths) {
  std::vector<MeshAnswer> ratios;
  for (const StudyRow* row : members) {
    const PressAnswers& a = row->answers[press];
    const double ratio = a.full.value / (a.small.value * depths);
    if (std::isfinite(ratio)) ratios.push_back({row->element_size, ratio});
  }
  if (ratios.empty()) return {};
  if (members.front()->element_size == 0) return {ratios.back().value, 0};
  const Estimate limit = Extrapolate(ratios).limit;
  if (std::isfinite(limit.value)) return limit;
  return {ratios.back().value, kOneMesh * std::abs(ratios.back().value - 1)};
}

// Any row's d ln force / d ln width, for rows too coarse to tell; the largest.
double LargestSlope(const std::vector<StudyRow>& rows, std::size_t press) {
  double slope = 0;
  for (const StudyRow& row : rows) {
    if (row.outcome != Outcome::kAnswered) continue;
    const double own = row.answers[press].width_slope;
    if (std::abs(own) > std::abs(slope)) slope = own;
  }
  return slope;
}

void JudgePress(const Reference& reference, const PressAnswers& answers, double slope,
                StudyRow* row) {
  const double width = 1 + answers.width_mismatch;
  const double width_error = width > 0 ? std::abs(std::pow(width, slope) - 1) : 0;
  const auto take_worse = [](double value, double* worst) {
    if (value <= *worst || std::isnan(*worst)) return false;  // so written, NaN is the worst
    *worst = value;
    return true;
  };
  const auto judge = [&](const Estimate& truth, double value, Estimate* worst, double* deviation) {
    const double bar = std::abs(truth.bar / truth.value);
    const double off = std::abs(value / truth.value - 1);
    if (deviation) take_worse(off, deviation);
    if (take_worse(off >= 0 ? std::max({off, bar, width_error}) : kUnknown, &worst->value)) {
      worst->bar = bar;
    }
  };
  take_worse(width_error, &row->width_error);
  judge(reference.small, answers.small.value, &row->error_small, nullptr);
  judge(reference.full, answers.full.value, &row->error, &row->deviation);
}

}  // namespace

std::optional<Estimate> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                        bool quick) {
  const bool is_solid = IsPlanar(scene.object.geometry) && scene.model.wall == 0;
  if (!is_solid || scene.model.contact != ContactLaw::kBonded) {
    return std::nullopt;
  }
  try {
    const double fine = Stiffness(scene, press, width, quick ? kCoarse : kFine);
    const double coarse = Stiffness(scene, press, width, quick ? kRough : kCoarse);
    if (!(fine > 0)) return std::nullopt;
    return Estimate{fine, std::abs(fine - coarse)};
  } catch (const std::exception&) {  // the formulation has limits of its own; others remain
    return std::nullopt;
  }
}

ReferenceFinder::ReferenceFinder(const Scene& scene, const PressSpec& question)
    : question_(question) {
  for (const Press& press : question.presses) {
    const auto stiffness =
        PlanarStiffness(scene, press, question.width, question.presses.size() > 2);
    const double d = question.small_depth;
    planar_.push_back(stiffness ? Estimate{d * stiffness->value, d * stiffness->bar} : Estimate{});
  }
}

Reference ReferenceFinder::FindOne(const std::vector<StudyRow>& rows, std::size_t press) const {
  const auto families = Families(rows);
  std::vector<Limit> limits;
  if (std::isfinite(planar_[press].value)) {
    limits.push_back({kIndependent,
                      "quadratic finite elements on a graded mesh, independent of the models",
                      planar_[press], true});
  }
  const bool any_linear = std::ranges::any_of(rows, IsLinearAnswer);
  for (const auto& [name, members] : families) {
    const StudyRow& finest = *members.front();
    if (any_linear && !finest.linear && finest.element_size > 0) continue;
    if (auto limit = LimitOf(members, press, question_.presses[press].loaded))
      limits.push_back(*std::move(limit));
  }
  if (limits.empty()) return {{}, {}, "none: too few answers to extrapolate"};
  const Limit& best = *std::ranges::min_element(
      limits, {}, [](const Limit& l) { return std::pair(!l.extrapolated, l.relative_bar()); });
  Reference reference{best.force, {}, best.words};
  if (const Limit* second = SecondOpinion(limits, best)) {
    const double apart = std::abs(second->force.value - best.force.value);
    // What was extrapolated contradicts nothing within the way that it went.
    const double own = std::max(second->force.bar, second->step);
    reference.small.bar = std::max(best.force.bar, apart - own);
    reference.source += "; differs from " + second->words +
                        Formatted(" by %.2g %%", 100 * apart / std::abs(best.force.value));
  } else {
    reference.source += "; no other formulation answered";
  }

  const double depths = question_.depth / question_.small_depth;
  Estimate stiffening{1, 0};
  for (const auto& [name, members] : families) {
    if (!IsLarge(*members.front())) continue;
    const Estimate found = Stiffening(members, press, depths);
    if (std::isfinite(found.value)) stiffening = found;
  }
  reference.full.value = reference.small.value * depths * stiffening.value;
  reference.full.bar = reference.full.value * (reference.small.bar / reference.small.value +
                                               stiffening.bar / stiffening.value);
  return reference;
}

References ReferenceFinder::Find(const std::vector<StudyRow>& rows) const {
  References references;
  for (std::size_t press = 0; press < question_.presses.size(); ++press) {
    references.presses.push_back(FindOne(rows, press));
  }
  const bool any_large = std::ranges::any_of(
      rows, [](const StudyRow& row) { return row.outcome == Outcome::kAnswered && IsLarge(row); });
  if (!any_large) {
    references.remark =
        "no model of large deformation answered: the errors leave out what it would change";
  }
  return references;
}

void JudgeRows(const References& references, std::vector<StudyRow>* rows) {
  for (StudyRow& row : *rows) {
    if (row.outcome != Outcome::kAnswered) continue;
    row.error = row.error_small = {-1, 0};
    row.deviation = row.width_error = -1;
    for (std::size_t i = 0; i < row.answers.size(); ++i) {
      const double own = row.answers[i].width_slope;
      const double slope = std::isfinite(own) ? own : LargestSlope(*rows, i);
      JudgePress(references.presses[i], row.answers[i], slope, &row);
    }
  }
}

}  // namespace palpate::study

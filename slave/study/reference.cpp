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
#include "slave/scene/model_kinds.h"
#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/true_body.h"
#include "slave/study/richardson.h"
#include "slave/study/volume_stiffness.h"

namespace palpate::study {
namespace {

constexpr site::Fineness kRough{
    .largest = 0.25, .growth = 0.6, .at_patch_end = 2e-3, .at_support_end = 2e-3};
constexpr site::Fineness kMedium{};
constexpr site::Fineness kFine{
    .largest = 0.1, .growth = 0.25, .at_patch_end = 2e-5, .at_support_end = 1e-4};

double Stiffness(const Scene& scene, const Press& press, double width,
                 const site::Fineness& fineness) {
  const site::TrueBody body(scene);
  const double nu = scene.object.material.poisson_ratio;
  const double unit = scene.object.material.young_modulus * ThicknessOf(scene.object.geometry);
  const site::BoundaryPlace place = body.Nearest(press.p_O.head<2>());
  const Eigen::Vector2d way = press.inward_O.head<2>();
  if (scene.model.contact == ContactLaw::kFrictionless) {
    return unit * site::SlidingStiffness(body, nu, scene.model.plane, place, width, way, fineness);
  }
  const auto bonded = site::SolvePatch(body, nu, scene.model.plane, place, width, fineness);
  return unit * way.dot(bonded.stiffness * way);
}

constexpr std::size_t kMany = 3;  // presses, which are a sample of how meshes lie under them
constexpr double kGood = 0.03;    // an independent answer's own bar, relative
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

// By finite elements graded for the press, as fine as a study has time for or otherwise.
std::optional<double> Graded(const Scene& scene, const Press& press, double width, bool many,
                             bool other) {
  if (press.loaded) return std::nullopt;
  if (IsVolume(scene.object.geometry)) {
    return VolumeStiffness(scene, press, width, width / (other ? 2 : 3));
  }
  const PlanarMesh own = many ? PlanarMesh::kRough : PlanarMesh::kFine;
  return PlanarStiffness(scene, press, width, other ? PlanarMesh::kMedium : own);
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

// What a row does at each press.
struct PressErrors {
  std::vector<Estimate> small, full;
  std::vector<double> deviation, width;
};

bool IsWorse(double a, double b) {
  return std::isnan(a) ? !std::isnan(b) : a > b;
}

// Of up to nine presses the worst, of more what nine of ten stay within: how a mesh happens to lie
// under one of many is no property of the mesh.
template <typename Value, typename Error>
Value AtNineOfTen(std::vector<Value> all, Error error) {
  const std::size_t beyond = all.size() / 10;
  std::ranges::sort(all,
                    [&](const Value& a, const Value& b) { return IsWorse(error(a), error(b)); });
  return all[beyond];
}

void JudgePress(const Reference& reference, const PressAnswers& answers, double slope, bool sole,
                PressErrors* errors) {
  const double width = 1 + answers.width_mismatch;
  const double width_error = width > 0 ? std::abs(std::pow(width, slope) - 1) : 0;
  const auto judge = [&](const Estimate& truth, double value) {
    const double bar = std::abs(truth.bar / truth.value);
    const double off = std::abs(value / truth.value - 1);
    return Estimate{off >= 0 ? std::max({off, bar, sole ? width_error : 0}) : kUnknown, bar};
  };
  errors->width.push_back(width_error);
  errors->small.push_back(judge(reference.small, answers.small.value));
  errors->full.push_back(judge(reference.full, answers.full.value));
  errors->deviation.push_back(std::abs(answers.full.value / reference.full.value - 1));
}

}  // namespace

std::optional<double> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                      PlanarMesh fineness) {
  if (!IsPlanar(scene.object.geometry) || scene.model.wall > 0) return std::nullopt;
  constexpr std::array kMeshes{kRough, kMedium, kFine};
  try {
    const double found =
        Stiffness(scene, press, width, kMeshes[static_cast<std::size_t>(fineness)]);
    return found > 0 ? std::optional(found) : std::nullopt;
  } catch (const std::exception&) {  // the formulation has limits of its own; others remain
    return std::nullopt;
  }
}

ReferenceFinder::ReferenceFinder(const Scene& scene, const PressSpec& question)
    : question_(question) {
  const bool many = question.presses.size() >= kMany;
  double bar = kUnknown;  // relative
  for (const Press& press : question.presses) {
    const auto stiffness = Graded(scene, press, question.width, many, false);
    if (stiffness && (!many || std::isnan(bar))) {
      const auto other = Graded(scene, press, question.width, many, true);
      bar = other ? std::abs(*other / *stiffness - 1) : kUnknown;
    }
    const double force = question.small_depth * stiffness.value_or(kUnknown);
    independent_.push_back({force, force * bar});
  }
}

Reference ReferenceFinder::FindOne(const std::vector<StudyRow>& rows, std::size_t press) const {
  const auto families = Families(rows);
  std::vector<Limit> limits;
  if (std::isfinite(independent_[press].bar)) {
    limits.push_back({kIndependent, "quadratic finite elements on a mesh graded for the press",
                      independent_[press], true});
  }
  const bool any_linear = std::ranges::any_of(rows, IsLinearAnswer);
  for (const auto& [name, members] : families) {
    const StudyRow& finest = *members.front();
    if (any_linear && !finest.linear && finest.element_size > 0) continue;
    if (auto limit = LimitOf(members, press, question_.presses[press].loaded))
      limits.push_back(*std::move(limit));
  }
  if (limits.empty()) return {{}, {}, "none: too few answers to extrapolate"};
  const bool settled = question_.presses.size() >= kMany && limits.front().kind == kIndependent &&
                       limits.front().relative_bar() < kGood;
  const Limit& best =
      settled ? limits.front() : *std::ranges::min_element(limits, {}, [](const Limit& l) {
        return std::pair(!l.extrapolated, l.relative_bar());
      });
  Reference reference{best.force, {}, best.words};
  // The limits of meshes that lie under each place otherwise contradict no answer that has a bar.
  if (settled) {
    reference.source += "; not held against others";
  } else if (const Limit* second = SecondOpinion(limits, best)) {
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
    PressErrors errors;
    const bool sole = row.answers.size() < kMany;
    for (std::size_t i = 0; i < row.answers.size(); ++i) {
      const double own = row.answers[i].width_slope;
      const double slope = std::isfinite(own) ? own : LargestSlope(*rows, i);
      JudgePress(references.presses[i], row.answers[i], slope, sole, &errors);
    }
    row.error = AtNineOfTen(errors.full, std::mem_fn(&Estimate::value));
    row.error_small = AtNineOfTen(errors.small, std::mem_fn(&Estimate::value));
    row.deviation = AtNineOfTen(errors.deviation, std::identity{});
    row.width_error = AtNineOfTen(errors.width, std::identity{});
  }
}

}  // namespace palpate::study

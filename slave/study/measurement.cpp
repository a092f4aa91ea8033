#include "slave/study/measurement.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/camera/touch_model.h"
#include "slave/pipeline/load/load_identifier.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/press_spec.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

constexpr int kSteps = 4;  // steps from the small depth to the full one, as in a manual press
constexpr std::size_t kMinRepeats = 5, kMaxRepeats = 1000;
constexpr int kHop = 10;  // every tenth update touches other elements

// Returns the answers that the slave estimates from the points of a membrane.
PressAnswers AnswerTo(const SeenPress& seen, LoadIdentifier* identifier) {
  identifier->Reset();
  SurfaceLoad load;
  for (const auto& points_O : seen.images_O) load = identifier->Fit(points_O);
  const Answer answer{IsForceKnown(load.validity) ? -load.force : kUnknown, load.validity,
                      load.reason};
  return {answer, answer};
}

// Finds the elements of positions, as the tracker does before it queries the model.
class Finder {
 public:
  explicit Finder(const ObjectMesh& mesh) : mesh_(mesh), skin_(SurfaceOf(mesh)) {}
  [[nodiscard]] const SurfaceMesh& skin() const { return skin_; }
  // Returns the element at a position; -1 for models without elements.
  [[nodiscard]] int ElementAt(const Vector3d& p_O) const {
    if (const auto* boundary = std::get_if<BoundaryMesh>(&mesh_)) {
      return FindElement(*boundary, p_O.head<2>());
    }
    if (skin_.triangles.empty()) return -1;
    const auto place = FindPlace(skin_, p_O);
    return place ? place->triangle : -1;
  }

 private:
  const ObjectMesh& mesh_;
  SurfaceMesh skin_;
};

bool HasMidnodes(const ModelOptions& model) {
  const ModelKind* kind = FindModelKind(model.kind);
  return kind != nullptr && kind->has_tets && model.fem.element == FemOptions::Element::kTet10;
}

PatchBasis LoadBasisOf(const ModelOptions& model) {
  return HasMidnodes(model) ? PatchBasis::kLoadedTriangles10 : PatchBasis::kLoadedTriangles;
}

// Returns whether the slave and `solve` correct the model's answers for the width that the mesh
// gives the tool.
bool CorrectsForTool(const Scene& scene) {
  return scene.tool && IsPlanar(scene.object.geometry) &&
         (KindOf(scene).is_plane || scene.sense.Find<Camera>() != nullptr);
}

// A scene without a tool is pressed by a flat one.
Tool ToolOf(const Scene& scene, const PressSpec& question) {
  return scene.tool.value_or(Tool{.width = question.width});
}

class Trial {
 public:
  Trial(std::unique_ptr<DeformationModel> model, const Candidate& candidate, const ObjectMesh& mesh,
        const PressSpec& question, const ModelFactory& factory)
      : made_(std::move(model)),
        touch_(CorrectsForTool(candidate.scene)
                   ? std::make_unique<TouchModel>(candidate.scene, std::get<BoundaryMesh>(mesh),
                                                  std::move(made_))
                   : nullptr),
        model_(touch_ ? *touch_->deformation : *made_),
        tool_(candidate.scene, ToolOf(candidate.scene, question), mesh),
        options_(candidate.scene.model),
        // A model that determines the touched nodes uses its own increments.
        steps_(candidate.linear || ShapesTool(candidate.scene) ? 1 : kSteps),
        finder_(mesh),
        question_(question),
        factory_(factory) {}

  [[nodiscard]] const DeformationModel& model() const { return model_; }

  PressAnswers Answer(const Press& press) {
    PressAnswers answers;
    model_.Reset();
    if (question_.small_depth < question_.depth) {
      answers.small = At(press, question_.small_depth);
      model_.Reset();
    }
    for (int step = 1; step <= steps_; ++step) {
      answers.full = At(press, question_.depth * step / steps_);
    }
    if (question_.small_depth == question_.depth) answers.small = answers.full;
    return answers;
  }

  // Measures single updates [s]: the tool moves deeper and back, and sometimes to other elements,
  // which determines the slowest percent. The updates are repeated three times and the shortest
  // time of each is used, to exclude delays by the machine.
  std::vector<double> Updates(const Press& press, double timing_s) {
    constexpr std::size_t kPasses = 3;
    std::array<std::vector<double>, kPasses> passes{Pass(press, timing_s, kMaxRepeats)};
    if (passes[0].size() <= kMinRepeats) return passes[0];
    std::size_t count = passes[0].size();
    for (std::size_t pass = 1; pass < kPasses; ++pass) {
      passes[pass] = Pass(press, timing_s, count);
      count = passes[pass].size();
    }
    std::vector<double> seconds(count);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<double, kPasses> same{passes[0][i], passes[1][i], passes[2][i]};
      seconds[i] = *std::ranges::min_element(same);
    }
    return seconds;
  }

 private:
  std::vector<double> Pass(const Press& press, double timing_s, std::size_t most) {
    std::vector<Contact> contacts;
    for (int hop = 0; hop < 3; ++hop) {
      const Vector3d p_O = press.p_O + (hop - 1) * 0.5 * question_.width * press.along_O;
      contacts.push_back(Moved(press, p_O, question_.width, 0));
    }
    model_.Reset();
    for (const Contact& contact : contacts) Respond(contact);  // the first calls allocate
    std::vector<double> seconds;
    const double end = factory_.now() + timing_s;
    while (seconds.size() < most && (seconds.size() < kMinRepeats || factory_.now() < end)) {
      const auto i = static_cast<int>(seconds.size());
      Contact& contact = contacts[Index(i / kHop % 3)];
      contact.prescribed_O = question_.depth * (0.5 + 0.05 * (i % kHop)) * press.inward_O;
      seconds.push_back(SecondsOf(contact));
    }
    return seconds;
  }

  // Long updates are measured in processor time, which other programs do not affect. That clock is
  // too slow for short updates, which are rarely interrupted.
  double SecondsOf(const Contact& contact) {
    constexpr double kShort = 1e-4;  // [s]
    const double worked = factory_.work ? factory_.work() : 0;
    const double began = factory_.now();
    Respond(contact);
    const double spent = factory_.now() - began;
    if (!factory_.work || spent < kShort) return spent;
    return std::min(spent, factory_.work() - worked);
  }

  [[nodiscard]] Contact Moved(const Press& press, const Vector3d& p_O, double width,
                              double depth) const {
    return {Contact::Kind::kDisplacement, p_O, finder_.ElementAt(p_O), width,
            depth * press.inward_O};
  }

  // Queries the model for a contact as the slave's estimators do.
  ContactResponse Respond(const Contact& contact) {
    if (!touch_) return tool_.Press(contact, &model_, &pressed_);
    BoundaryPlace place;
    place.element = contact.element;
    place.p_O = contact.p_O.head<2>();
    place.normal_O = touch_->mesh.elements[Index(contact.element)].normal();
    const Vector3d n = Planar(place.normal_O);
    const bool slides = touch_->law == ContactLaw::kFrictionless;
    const Vector3d& moved_O = contact.prescribed_O;
    return touch_->Press(place, {.displacement_O = slides ? Vector3d(n.dot(moved_O) * n) : moved_O,
                                 .rolled_O = Vector3d::Zero()});
  }

  study::Answer At(const Press& press, double depth) {
    const double width = question_.width;
    if (press.loaded) return Push(press, depth, width);
    const ContactResponse response = Respond(Moved(press, press.p_O, width, depth));
    if (!IsForceKnown(response.validity)) return {};
    return {press.inward_O.dot(response.force_O), response.validity, response.flag_reason};
  }

  study::Answer Push(const Press& press, double depth, double width) {
    const double force = question_.load * depth / question_.depth;
    const auto points =
        RoundLoad(finder_.skin(), press.p_O, press.inward_O, width, HasMidnodes(options_));
    std::vector<Contact> contacts;
    for (const LoadPoint& point : points) {
      contacts.push_back({Contact::Kind::kForce, point.p_O, point.triangle, 0,
                          point.share * force * press.inward_O});
    }
    std::vector<ContactResponse> responses(contacts.size());
    model_.Respond(contacts, responses);
    double displacement = 0;
    Validity validity = points.empty() ? Validity::kFailed : Validity::kValid;
    std::string_view flag_reason;
    if (IsCoarseUnder(press, width)) {
      validity = Worse(validity, Validity::kExtrapolated);
      flag_reason = kCoarsePatch;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!IsForceKnown(responses[i].validity)) return {};
      displacement += points[i].share * press.inward_O.dot(responses[i].displacement_O);
      validity = Worse(validity, responses[i].validity);
      if (flag_reason.empty()) flag_reason = responses[i].flag_reason;
    }
    return {force * depth / displacement, validity, flag_reason};
  }

  // Returns whether the mesh is too coarse: the load's area is that of the tool on every mesh, but
  // a coarse mesh blurs its rim.
  [[nodiscard]] bool IsCoarseUnder(const Press& press, double width) const {
    const auto place = FindPlace(finder_.skin(), press.p_O);
    if (!place) return false;
    PatchCover cover =
        CoverOf(PatchAt(finder_.skin(), *place, press.p_O, width), LoadBasisOf(options_));
    cover.area = cover.disc.area;
    return IsPatchCoarse(cover);
  }

  std::unique_ptr<DeformationModel> made_;
  std::unique_ptr<TouchModel> touch_;  // null: the slave uses the model's answers unchanged
  DeformationModel& model_;
  ToolPress tool_;
  Solution pressed_;
  const ModelOptions& options_;
  const int steps_;
  Finder finder_;
  const PressSpec& question_;
  const ModelFactory& factory_;
};

void Describe(const Candidate& candidate, StudyRow* row) {
  static_cast<Trait&>(*row) = candidate;
  row->kind = candidate.scene.model.kind;
  row->model = candidate.scene.model;
  if (const auto* box = std::get_if<BoxGeometry>(&candidate.scene.object.geometry)) {
    row->cells = box->cells;
  }
  const ModelKind* kind = FindModelKind(row->kind);
  if (kind != nullptr && kind->iterates) {
    row->residual = candidate.scene.model.fem.residual;
  }
}

double Quantile(const std::vector<double>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::ceil(share * last))];
}

bool IsAnswer(const Answer& answer) {
  return answer.validity != Validity::kFailed && std::isfinite(answer.value);
}

void Try(const Candidate& candidate, const PressSpec& question, const ModelFactory& factory,
         Progress* progress, double timing_s, StudyRow* row) {
  const ObjectMesh mesh = MeshObject(candidate.scene, std::nullopt);
  const double began = factory.now();
  auto model = factory.make(candidate.scene, mesh, progress);
  const ModelInfo& info = model->info();
  if (info.dof > 0) row->dof = info.dof;
  row->memory_bytes = info.memory_bytes;
  row->reason = info.remark;
  Trial trial(std::move(model), candidate, mesh, question, factory);
  const auto identifier =
      question.seen.empty() ? nullptr : MakeLoadIdentifier(candidate.scene, progress);
  row->precompute_s = factory.now() - began;
  row->validity = Validity::kValid;
  for (std::size_t i = 0; i < question.presses.size(); ++i) {
    row->answers.push_back(identifier ? AnswerTo(question.seen[i], identifier.get())
                                      : trial.Answer(question.presses[i]));
    const Answer& full = row->answers.back().full;
    row->validity = Worse(row->validity, full.validity);
    row->beyond += full.validity == Validity::kValid ? 0 : 1;
    if (!full.flag_reason.empty()) row->reason = full.flag_reason;
    if (IsAnswer(row->answers.back().small)) continue;
    row->outcome = Outcome::kFailed;
    const std::string_view why = trial.model().failure();
    row->reason = why.empty() ? "no solution" : std::string(why);
    return;
  }
  // A flagged answer skips some of the work.
  const auto valid = std::ranges::find_if(row->answers, [](const PressAnswers& answers) {
    return answers.full.validity == Validity::kValid;
  });
  const auto timed =
      valid == row->answers.end() ? 0 : static_cast<int>(valid - row->answers.begin());
  std::vector<double> seconds = trial.Updates(question.presses[Index(timed)], timing_s);
  std::ranges::sort(seconds);
  row->update_median_s = Quantile(seconds, 0.5);
  row->update_p99_s = Quantile(seconds, 0.99);
  row->outcome = Outcome::kAnswered;
}

}  // namespace

const char* ToString(Outcome outcome) {
  constexpr std::array<const char*, 3> kOutcomes{"answered", "failed", "skipped"};
  return kOutcomes[static_cast<std::size_t>(outcome)];
}

ModelFactory DefaultModelFactory() {
  return {[](const Scene& scene, const ObjectMesh& mesh, Progress* progress) {
            return MakeModel(scene, mesh, progress);
          },
          [] {
            const auto now = std::chrono::steady_clock::now().time_since_epoch();
            return std::chrono::duration<double>(now).count();
          },
          [] {
            timespec time{};
            clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
            return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
          }};
}

StudyRow Skipped(const Candidate& candidate, std::string reason) {
  StudyRow row;
  Describe(candidate, &row);
  row.reason = std::move(reason);
  return row;
}

StudyRow Measure(const Candidate& candidate, const PressSpec& question, const ModelFactory& factory,
                 Progress* progress, double timing_s) {
  StudyRow row;
  Describe(candidate, &row);
  try {
    Try(candidate, question, factory, progress, timing_s, &row);
  } catch (const Interrupted&) {
    row.outcome = Outcome::kSkipped;
    row.reason = "stopped";
  } catch (const std::bad_alloc&) {
    row.outcome = Outcome::kFailed;
    row.reason = "out of memory";
  } catch (const std::exception& error) {
    row.outcome = Outcome::kFailed;
    row.reason = error.what();
  }
  return row;
}

}  // namespace palpate::study

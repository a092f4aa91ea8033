#include "slave/commands/evaluate/estimated_shape.h"

#include <optional>
#include <stdexcept>
#include <variant>

#include "slave/capture/tactile_recording.h"
#include "slave/commands/solve/solve_rows.h"
#include "slave/mechanics/make_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/study/shape/finger_capsule.h"

namespace palpate {
namespace {

SurfaceMesh SurfaceFor(const ObjectMesh& mesh) {
  if (const auto* surface = std::get_if<SurfaceMesh>(&mesh)) return *surface;
  if (const auto* solid = std::get_if<SolidMesh>(&mesh)) return SurfaceOf(*solid);
  throw std::invalid_argument("object.geometry: accepted by evaluate is a volume: box or mesh");
}

std::vector<Contact> ContactsOf(const std::vector<SolveRow>& rows) {
  std::vector<Contact> contacts;
  for (const SolveRow& row : rows) {
    contacts.push_back(row.contact);
    contacts.back().wants_stiffness = false;
  }
  return contacts;
}

std::vector<Eigen::Vector3d> Displacement(const Scene& scene, const ObjectMesh& mesh,
                                          const std::vector<SolveRow>& rows, Progress* progress) {
  const auto model = MakeModel(scene, mesh, progress);
  const std::vector<Contact> contacts = ContactsOf(rows);
  std::vector<ContactResponse> responses(contacts.size());
  model->Reset();
  model->Prefetch(contacts);
  model->Respond(contacts, responses);
  if (responses.front().validity == Validity::kFailed) {
    throw std::invalid_argument("the tables have no answer: " + std::string(model->failure()));
  }
  std::vector<Eigen::Vector3d> displacement;
  model->Displacements(&displacement);
  return displacement;
}

}  // namespace

EstimatedShape ShapeUnderTables(const Scene& scene, const std::filesystem::path& contacts,
                                const std::filesystem::path& loads, Progress* progress) {
  Scene still = scene;  // what a load comes to in the end, however it gets there
  still.model.fem.time = FemOptions::Time::kStatic;
  const ObjectMesh mesh = MeshObject(still, std::nullopt);
  EstimatedShape shape;
  shape.rest_S = SurfaceFor(mesh);
  shape.estimate_S = shape.rest_S;
  shape.state = "at rest";
  std::vector<SolveRow> rows;
  if (!contacts.empty()) {
    AppendRows(contacts, Contact::Kind::kDisplacement, mesh, false, &rows);
  }
  if (!loads.empty()) AppendRows(loads, Contact::Kind::kForce, mesh, false, &rows);
  if (!rows.empty()) {
    shape.state = "what the model makes of " + std::to_string(rows.size()) + " contacts";
    const auto u_O = Displacement(still, mesh, rows, progress);
    for (std::size_t i = 0; i < u_O.size(); ++i) shape.estimate_S.nodes[i] += u_O[i];
  }
  for (SurfaceMesh* surface : {&shape.rest_S, &shape.estimate_S}) {
    for (auto& p : surface->nodes) p = still.object.X_SO * p;
  }
  return shape;
}

EstimatedShape ShapeAfterRecording(const Scene& scene, Progress* progress) {
  EstimatedShape shape = ShapeUnderTables(scene, {}, {}, nullptr);
  const auto* tactile = scene.sense.Find<Tactile>();
  if (!tactile || tactile->source != Tactile::Source::kRecording) return shape;
  const auto source = OpenTactileRecording(scene, false);
  TactileEstimator estimator(scene);
  while (const auto frame = source->Next({})) {
    estimator.Feel(*frame, scene.manipulator.home);
    if (progress && !progress->Report(source->description(), 0)) throw Interrupted();
  }
  for (int i = 0; i < estimator.finger_count(); ++i) {
    const FingerEstimate& finger = estimator.finger(i);
    if (!finger.has_pose) continue;
    shape.fingers_S.push_back(study::FingerCapsule(finger.X_SF, tactile->finger_radius));
  }
  if (estimator.body() == nullptr) {
    shape.state = "at rest: nobody says where the fingertips are";
    return shape;
  }
  shape.estimate_S.triangles = estimator.body()->surface.triangles;
  estimator.DeformedNodes(&shape.estimate_S.nodes);
  shape.state = "what the fingertips tell at the end of " + tactile->file.filename().string();
  return shape;
}

}  // namespace palpate

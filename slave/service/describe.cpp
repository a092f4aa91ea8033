// Converts descriptions of the slave to messages.
#include <cmath>
#include <filesystem>
#include <utility>

#include "shared/program/program.h"
#include "shared/wire/fields.h"
#include "slave/scene/scene_text.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

// Returns the last name of a path for display: `network.json`, or `rnn_21` for `nets/rnn_21/`.
std::string NameOf(const std::filesystem::path& path) {
  return path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
}

void AddFingertips(const Tactile& tactile, v1::SceneDescription* message) {
  for (const Finger& finger : tactile.fingers) {
    auto* fingertip = message->add_fingertips();
    fingertip->set_name(finger.name);
    fingertip->set_network(NameOf(tactile.network));
    fingertip->set_rate(tactile.rate);
    ToProto(finger.X_SF.translation(), fingertip->mutable_p_s_finger());
    ToProto(Eigen::Quaterniond(finger.X_SF.linear()), fingertip->mutable_orientation());
  }
}

void AddCapabilities(const SlaveDescription& description, v1::Capabilities* message) {
  constexpr std::uint32_t kPlanarFreedom = 2, kFreedom = 3, kWithRotation = 6;
  const Scene& scene = description.scene;
  ToProto(scene.manipulator.workspace_min, message->mutable_workspace_min());
  ToProto(scene.manipulator.workspace_max, message->mutable_workspace_max());
  const bool is_planar = IsPlanar(scene.object.geometry) && !scene.sense.Find<Tactile>();
  const std::uint32_t translations = is_planar ? kPlanarFreedom : kFreedom;
  message->set_degrees_of_freedom(description.turns ? kWithRotation : translations);
  message->set_sensor_rate(SensorRate(scene.sense));
  message->add_local_models(v1::LocalModel::KIND_UNILATERAL_PLANE);
  message->add_local_models(v1::LocalModel::KIND_SURFACE_PATCH);
  message->set_max_speed(scene.manipulator.max_speed);
  message->set_max_position_scale(kMaxPositionScale);
  message->set_max_force_scale(kMaxForceScale);
  message->set_simulated(description.simulated);
  message->set_version(Version());
}

}  // namespace

void ToProto(const SlaveDescription& description, v1::SceneDescription* message) {
  const Scene& scene = description.scene;
  message->set_name(scene.name);
  message->set_geometry(InWords(scene.object.geometry));
  message->set_source(description.sense.source);
  message->set_units("SI: m, N, s, Pa");
  message->set_setup_camera(description.setup_camera);
  message->set_settings_revision(description.settings_revision);

  auto* material = message->mutable_material();
  material->set_young_modulus(scene.object.material.young_modulus);
  material->set_poisson_ratio(scene.object.material.poisson_ratio);
  material->set_density(scene.object.material.density);

  auto* model = message->mutable_model();
  model->set_kind(description.sense.model.kind);
  model->set_reason(description.sense.reason);
  model->set_dof(description.sense.model.dof);
  model->set_elements(static_cast<std::uint32_t>(description.sense.model.elements));
  model->set_plane(scene.model.plane == Plane::kStrain ? "strain" : "stress");
  model->set_contact(std::string(WordOf(scene.model.contact)));
  model->set_range(description.sense.model.range);

  const OperatorOptions& options = scene.operator_options;
  auto* mapping = message->mutable_operator_();
  mapping->set_position_scale(options.transform.position_scale);
  mapping->set_force_scale(options.transform.force_scale);
  mapping->set_force_limit(options.force_limit);
  ToProto(Eigen::Quaterniond(options.transform.R_SM), mapping->mutable_orientation());
  mapping->set_press_depth(options.press_depth);
  mapping->set_press_speed(options.press_speed);
  mapping->set_dead_after(scene.link.dead_after);
  if (const auto* tactile = scene.sense.Find<Tactile>()) AddFingertips(*tactile, message);
  AddCapabilities(description, message->mutable_capabilities());
}

void ToProto(const SlaveStatus& status, v1::Status* message) {
  message->set_phase(ToProto(status.phase));
  message->set_validity(ToProto(status.validity));
  message->set_samples(status.frames);
  message->set_commands(status.commands);
  message->set_commands_refused(status.commands_refused);
  message->set_stops(status.stops);
  message->set_sample_rate(status.frame_rate);
  ToProto(status.started_at, message->mutable_started_at());
  ToProto(Clock::now(), message->mutable_now());
  for (const StageTimes& times : status.stages) {
    auto* stage = message->add_stages();
    stage->set_stage(times.stage);
    stage->set_p50_us(times.p50_us);
    stage->set_p99_us(times.p99_us);
    stage->set_max_us(times.max_us);
  }
  for (const std::string& alarm : status.alarms) message->add_alarms(alarm);
  if (status.arm) ToProto(*status.arm, message->mutable_arm());
  if (status.cameras) ToProto(*status.cameras, message->mutable_cameras());
}

void ToProto(const BoundaryShape& shape, bool with_topology, v1::MeshState* message) {
  message->Clear();
  message->set_sequence(shape.state_sequence);
  ToProto(shape.sensed_at, message->mutable_sensed_at());
  message->set_validity(ToProto(shape.validity));
  if (with_topology) {
    message->mutable_elements()->Assign(shape.elements.begin(), shape.elements.end());
    message->set_nodes_per_element(static_cast<std::uint32_t>(shape.nodes_per_element));
    message->mutable_rest()->Assign(shape.rest.begin(), shape.rest.end());
    message->mutable_fixed_nodes()->Assign(shape.fixed_nodes.begin(), shape.fixed_nodes.end());
  }
  message->mutable_positions()->Assign(shape.positions.begin(), shape.positions.end());
  message->mutable_nodal_forces()->Assign(shape.nodal_forces.begin(), shape.nodal_forces.end());
  if (!shape.field) return;
  v1::DisplacementField* field = message->mutable_field();
  if (with_topology) {
    field->mutable_triangles()->Assign(shape.field->triangles.begin(),
                                       shape.field->triangles.end());
    field->mutable_rest()->Assign(shape.field->rest.begin(), shape.field->rest.end());
  }
  field->mutable_displacement()->Assign(shape.field->displacement.begin(),
                                        shape.field->displacement.end());
  field->mutable_image()->Assign(shape.field->image.begin(), shape.field->image.end());
}

void ToProto(EncodedImage image, std::uint64_t sequence, v1::ImageState* message) {
  message->Clear();
  message->set_sequence(sequence);
  ToProto(image.sensed_at, message->mutable_sensed_at());
  message->set_jpeg(std::move(image.jpeg));
  message->set_width(static_cast<std::uint32_t>(image.width));
  message->set_height(static_cast<std::uint32_t>(image.height));
}

}  // namespace palpate

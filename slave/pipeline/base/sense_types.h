// Inputs and reports of a sensing pipeline as plain values, for code that uses a slave without a
// pipeline.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/state/slave_state.h"
#include "slave/mechanics/model_info.h"
#include "slave/scene/model_kinds.h"

namespace palpate {

struct StageTimes {
  std::string stage;
  double p50_us = 0, p99_us = 0, max_us = 0;
};

// A change of SetModel.
struct ModelChange {
  std::string kind;  // empty: unchanged
};

// Parts of a shape that cost time and are computed only on request.
struct ShapeParts {
  bool nodal_forces = false, field = false;
};

// See DisplacementField of state.proto.
struct DisplacementField {
  std::vector<std::uint32_t> triangles{};     // node indices, three at a time
  std::vector<float> rest{}, displacement{};  // x, y, z per node, frame O [m]
  std::vector<float> image{};                 // u, v per displaced node [px]; empty: no camera
};

// The deformed boundary: its vertices, frame S [m].
struct BoundaryShape {
  std::uint64_t state_sequence = 0;
  Time sensed_at{};
  Validity validity = Validity::kFailed;
  int nodes_per_element = 2;            // 2: lines of a planar object, 3: triangles
  std::vector<std::uint32_t> elements;  // vertex indices, `nodes_per_element` at a time
  std::vector<float> rest, positions;   // x, y, z per vertex
  std::vector<float>
      nodal_forces;  // x, y, z per vertex, of the tool on the object [N]; empty unless requested
  // Pressure of the tool on the object per vertex [Pa], if the model provides more than nodal
  // forces; otherwise empty, also unless requested.
  std::vector<float> traction;
  std::vector<std::uint32_t> fixed_nodes;  // vertices that the scene fixes along at least one axis
  std::optional<DisplacementField> field;  // nullopt: not requested, or no model
};

// Description of the sensing, for people and for code that needs its limits.
struct SenseInfo {
  std::string source;   // of samples
  std::string samples;  // kind of samples: images, pairs, samples
  // sigma of the measured tip position [m]; 0: only the encoders measure it.
  double tip_resolution = 0;
  bool has_force_estimate = true;     // false: only the object's position
  ModelInfo model;                    // kind `none`: there is none
  std::string reason;                 // why this model
  std::vector<std::string> remarks;   // remarks before the first contact, one sentence each
  std::optional<ObjectClass> object;  // class whose kinds SetModel accepts; nullopt: no model
  bool is_awaited = false;            // no sample yet: model and remarks are unknown
};

}  // namespace palpate

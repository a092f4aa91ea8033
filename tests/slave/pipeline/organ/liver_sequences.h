// ../shared/data/liver_registration: clouds on the front of a liver under known forces (Mestdagh
// and Cotin 2022).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"

namespace palpate::liver {

bool IsThere();

struct Liver {
  SolidMesh mesh;
  HeldNodes held;
  std::vector<std::array<int, 3>> seen;
};
Liver ReadLiver(const std::string& mesh);  // default, remeshed

struct Frame {
  std::vector<Eigen::Vector3d> cloud;  // [m]
  Eigen::Vector3d force;               // on the liver [N, or what E gives]
};
std::vector<Frame> ReadSequence(const std::string& name);  // linear/s1
std::vector<std::string> Sequences(const std::string& law);

}  // namespace palpate::liver

// Linear elasticity of a plane body in quadratic triangles (T6), unit thickness, displacements
// prescribed on chosen nodes. Plane stress: displacements alone. Plane strain: displacements and a
// continuous linear pressure (Taylor & Hood, Computers & Fluids 1, 1973), which holds up to and
// including nu = 0.5:
//
//   2 G (eps(u), eps(v)) + (p, div v) = 0,    (div u, q) - (1 / lambda) (p, q) = 0
//
// The caller chooses the units; the simulator uses E = 1 and the body's larger side = 1.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/graded_mesh.h"
#include "slave/scene/scene.h"

namespace palpate::simulation {

// Nodes: the corners (numbered as in the TriangleMesh), then the mid-edge nodes.
struct QuadraticMesh {
  explicit QuadraticMesh(const TriangleMesh& mesh);

  struct BoundaryEdge {
    std::array<int, 3> node;  // start, mid-edge node, end; the body is on the left
    int tag;
  };
  std::vector<Eigen::Vector2d> nodes;
  int corner_count = 0;
  std::vector<std::array<int, 6>> triangles;  // corners 0 1 2, mid-edge nodes 01, 12, 20
  std::vector<BoundaryEdge> boundary;
};

struct PlaneMaterial {
  double E = 1;   // [Pa] or 1
  double nu = 0;  // [-], -1 < nu <= 0.5; plane stress, too
  Plane plane = Plane::kStress;
};

// Prescribed flags the node displacements that are prescribed: nodes x (x, y).
using Prescribed = Eigen::Array<bool, Eigen::Dynamic, 2, Eigen::RowMajor>;
// Several load cases side by side: nodes x (x, y per case).
using Fields = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct ElasticSolution {
  Fields displacement;  // nodes x 2 cases
  Fields reaction;      // nodes x 2 cases: force on the body; zero at free nodes
};

// `values`: nodes x 2 cases, read where `prescribed`. At least three degrees of freedom must be
// prescribed so that the body cannot move freely. Throws std::runtime_error if the equations have
// no finite solution. Cost: one sparse factorisation.
ElasticSolution SolveElastic(const QuadraticMesh& mesh, const PlaneMaterial& material,
                             const Prescribed& prescribed, const Fields& values);

}  // namespace palpate::simulation

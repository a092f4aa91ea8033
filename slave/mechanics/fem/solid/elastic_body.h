// The elastic energy of a meshed body, its derivatives, mass and weight. Nondimensional: lengths in
// some unit L, stresses in Young's moduli E, forces in E L^2.
//
//   W(u, p) = integral of A(F) + p g(F) - p^2 / (2 k)
//
// Elements may have pressure unknowns: p is then continuous and linear between the vertices. Ten
// nodes need nothing more (Taylor-Hood element). With four nodes the difference of p to its mean in
// the element is penalised, - (p - mean p)^2 / (4 mu) in W (Dohrmann and Bochev, Int. J. Numer.
// Meth. Fluids 46, 2004).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/material_law.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// In an element of relative modulus c the law is multiplied: c A, c k.
class ElasticBody {
 public:
  // Stores references to the mesh and the layout, whose pressures it uses if there are any.
  ElasticBody(const TetMesh& mesh, const BlockLayout& layout, const MaterialLaw& law);

  // W, and its gradient over all unknowns, rows of the layout. NaN where `x` is not finite.
  double Energy(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const;
  // Returns the energy W.
  [[nodiscard]] double Energy(const Eigen::VectorXd& x) const;
  // Adds the second derivatives of W. `regularised` replaces 1 / k by at least
  // kMinCompressibility in the rows of the pressure, so that the matrix can be factored.
  void AddTangent(const Eigen::VectorXd& x, const Tangent& tangent, bool regularised,
                  SparseMatrix* matrix) const;
  static constexpr double kMinCompressibility = 1e-5;

  // Integral over the body of the shape function of every vertex's pressure times g.
  void VolumeChange(const Eigen::VectorXd& x, Eigen::VectorXd* change) const;
  // Mass per density, one by each element's modulus, over the pressure's shape functions; vertices
  // as numbered in the mesh, upper triangle.
  [[nodiscard]] SparseMatrix PressureMass() const;

  // Mass at density one (per L^3), equal for all three components.
  void AddMass(double factor, SparseMatrix* matrix) const;
  // Integral of every node's shape function, per node: weight, and mean values.
  [[nodiscard]] Eigen::VectorXd NodeVolumes() const;

  // det F over the quadrature points and, with ten nodes, the corners; F = I + grad u.
  struct Jacobians {
    double smallest = 0;
    int inverted = 0, first_inverted = -1;  // elements with one that is not > 0; the first
  };
  [[nodiscard]] Jacobians FindJacobians(const Eigen::VectorXd& x) const;

  [[nodiscard]] const MaterialLaw& law() const { return law_; }

 private:
  // Matrix of - W in the pressures of an element of unit volume and modulus.
  [[nodiscard]] Eigen::Matrix4d PressureMatrix(double compressibility, int nodes_per_element) const;
  template <int kNodes>
  struct Local;  // one element's unknowns and geometry
  template <int kNodes>
  [[nodiscard]] Local<kNodes> Gather(const Eigen::VectorXd& x, int element) const;
  [[nodiscard]] Eigen::Matrix3d StrainAt(const Eigen::VectorXd& x, int element,
                                         const Eigen::Vector4d& bary) const;
  template <int kNodes>
  double AddElement(const Local<kNodes>& local, ElementMatrix* gradient) const;
  template <int kNodes>
  double EnergyOf(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const;
  template <int kNodes>
  void AddTangents(const Eigen::VectorXd& x, const Tangent& tangent, bool regularised,
                   SparseMatrix* matrix) const;

  const TetMesh& mesh_;
  const BlockLayout& layout_;
  MaterialLaw law_;
  std::vector<TetGeometry> geometry_;
};

}  // namespace palpate

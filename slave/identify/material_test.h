// A material test: rows of a deformation and the measured stresses.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/identify/hyper_law.h"

namespace palpate::identify {

enum class TestKind { kUniaxial, kEquibiaxial, kPlanar, kBiaxial, kShear, kTensor };

// Stretches along, across and through the specimen under a load of this kind with free faces;
// planar keeps the second at 1. The volume is kept. `across`: for kBiaxial.
Eigen::Vector3d PrincipalStretches(TestKind kind, double stretch, double across = 1);

struct TestRow {
  double abscissa = 1;           // stretch, amount of shear
  double across = 1;             // second stretch of kBiaxial
  Eigen::Matrix3d F;             // of kTensor
  std::vector<double> measured;  // one per component [Pa]
};

struct MaterialTest {
  TestKind kind = TestKind::kUniaxial;
  std::string name;                             // of the file
  bool cauchy = false;                          // true stress; else nominal (first Piola-Kirchhoff)
  std::vector<std::pair<int, int>> components;  // of the stress that were measured
  std::vector<TestRow> rows;
  std::vector<std::string> remarks;  // on its table, a sentence each
  double end_factor = 1;  // factor by which bonded ends stiffen the specimen, see bonded_cylinder.h
  double area = 0;        // area of the loaded section at rest [m^2]; 0: unknown
  // Whether the units of all used columns are given by the header or an option.
  bool units_named = true;

  [[nodiscard]] double Peak() const;  // largest size of a measured stress [Pa]
  [[nodiscard]] std::size_t values() const { return rows.size() * components.size(); }
};

// Deformation gradient of a row.
Eigen::Matrix3d DeformationOf(const MaterialTest& test, const TestRow& row);

// The model's stress in row `row`, with as many entries as `components` [Pa], bonded ends included.
Eigen::VectorXd Predict(const HyperLaw& law, const MaterialTest& test, std::size_t row);
// The stresses of all rows, one after the other.
Eigen::VectorXd Predict(const HyperLaw& law, const MaterialTest& test);
Eigen::VectorXd Predict(const HyperLaw& law, const std::vector<MaterialTest>& tests);
// The measured values in the same order.
Eigen::VectorXd Measured(const MaterialTest& test);
Eigen::VectorXd Measured(const std::vector<MaterialTest>& tests);

// Number of measured values, and their largest size [Pa].
std::size_t ValuesOf(const std::vector<MaterialTest>& tests);
double PeakOf(const std::vector<MaterialTest>& tests);

// Returns why no isotropic model can fit a test: equal stretches in two directions with stresses
// that differ by more than a tenth of the peak. Empty: it can.
std::string AgainstIsotropy(const MaterialTest& test);

// Strains, the first not above zero, between which a straight line with the law's modulus at rest
// is within a tenth of its uniaxial stress.
std::pair<double, double> LinearRange(const HyperLaw& law);

// Largest principal strain of a row, stretched or compressed [-].
double LargestStrain(const MaterialTest& test, const TestRow& row);

// Smallest and largest principal stretch of all deformations.
std::pair<double, double> StretchRange(const std::vector<MaterialTest>& tests);

}  // namespace palpate::identify

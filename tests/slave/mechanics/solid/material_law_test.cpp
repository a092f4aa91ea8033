// Laws at a point: derivatives by differences, objectivity, rest, small strains, inversion; and the
// element's patch tests.
#include "slave/mechanics/fem/solid/material_law.h"

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "shared/geometry/symmetric_eigen.h"
#include "slave/mechanics/fem/solid/elastic_body.h"
#include "tests/slave/mechanics/solid/bodies.h"

namespace palpate {
namespace {

using namespace solid_tests;  // NOLINT(google-build-using-namespace): its helpers are for here
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3d Turn(const Vector3d& axis, double degrees) {
  return Eigen::AngleAxisd(degrees * std::acos(-1.0) / 180, axis.normalized()).toRotationMatrix();
}

class EveryLaw : public testing::TestWithParam<std::tuple<Law, double>> {
 protected:
  // Ogden's law is not defined for inverted elements, and not smooth near inversion.
  [[nodiscard]] bool IsSmoothAt(const Matrix3d& H) const {
    const auto s = SignedSvdOf(Matrix3d::Identity() + H).s;
    return is_ogden_ ? s[2] > 0.3 : s[1] + s[2] > 0.2;  // near where a rotation is not defined
  }
  const bool is_ogden_ = std::get<0>(GetParam()) == Law::kOgden;
  const MaterialLaw law_{std::get<0>(GetParam()), std::get<1>(GetParam()),
                         is_ogden_ ? kRubber : std::vector<OgdenTerm>{}};
};

// Energy, stress and tangent are derivatives of each other: central differences with step 1e-5 have
// a truncation error of 1e-10 and a rounding error of 1e-11, for values of order one (ten near nu =
// -0.9).
TEST_P(EveryLaw, StressAndTangentAreDerivatives) {
  std::mt19937 engine(1);
  const double step = 1e-5;
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix3d H = Random(&engine, 0.6);
    const Matrix3d dH = Random(&engine, 1);
    const double p = 0.3;
    const auto energy = [&](double t) {
      const auto point = law_.At(H + t * dH);
      return point.energy + p * point.g;
    };
    const auto stress = [&](double t) {
      const auto point = law_.At(H + t * dH);
      return Matrix3d(point.stress + p * point.volume_stress);
    };
    if (!IsSmoothAt(H)) continue;
    const double tolerance = is_ogden_ ? 1e-6 : 1e-7;  // of numbers of order one to ten
    EXPECT_NEAR((energy(step) - energy(-step)) / (2 * step), (stress(0).array() * dH.array()).sum(),
                tolerance);
    const Eigen::Matrix<double, 9, 1> moved =
        law_.TangentAt(H, p, 0, kExactTangent) * dH.reshaped();
    const Matrix3d difference = (stress(step) - stress(-step)) / (2 * step);
    EXPECT_LT((moved - difference.reshaped()).norm(),
              10 * tolerance * (is_ogden_ ? 1 + difference.norm() : 1));
  }
}

TEST_P(EveryLaw, ProjectedTangentIsNeverNegative) {
  std::mt19937 engine(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix3d H = Random(&engine, 2);
    if (is_ogden_ && !IsSmoothAt(H)) continue;
    const Matrix9d D = law_.TangentAt(H, -1, 0, kProjectedTangent);
    const Eigen::VectorXd values = EigenOf(D).values;
    EXPECT_GT(values.minCoeff(), -1e-12 * values.maxCoeff());
  }
}

// At rest: no stress, and the tangent of Hooke's law.
TEST_P(EveryLaw, RestIsStressFreeAndHookean) {
  const auto rest = law_.At(Matrix3d::Zero());
  EXPECT_EQ(rest.stress.norm(), 0);
  EXPECT_EQ(rest.energy, 0);
  const double nu = std::get<1>(GetParam());
  const Matrix9d hooke =
      MaterialLaw(Law::kLinear, nu)
          .TangentAt(Matrix3d::Zero(), 0, nu / ((1 + nu) * (1 - 2 * nu)), kExactTangent);
  const Matrix9d ours =
      law_.TangentAt(Matrix3d::Zero(), 0, 1 / law_.compressibility(), kExactTangent);
  EXPECT_LT((ours - hooke).norm(), (is_ogden_ ? 1e-12 : 1e-13) * hooke.norm());
}

// Strains of 1e-18 keep their digits: stress is Hooke's to second order of the strain.
TEST_P(EveryLaw, VanishingStrainsKeepTheirDigits) {
  std::mt19937 engine(4);
  const Matrix3d H = Random(&engine, 1e-18);
  const double nu = std::get<1>(GetParam()), mu = 0.5 / (1 + nu);
  const Matrix3d strain = 0.5 * (H + H.transpose());
  const Matrix3d hooke =
      2 * mu * strain + nu / ((1 + nu) * (1 - 2 * nu)) * strain.trace() * Matrix3d::Identity();
  const auto point = law_.At(H);
  const Matrix3d ours = point.stress + point.g / law_.compressibility() * point.volume_stress;
  EXPECT_LT((ours - hooke).norm(), (is_ogden_ ? 1e-13 : 1e-14) * hooke.norm());
}

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw,
                         testing::Combine(testing::Values(Law::kLinear, Law::kCorotational,
                                                          Law::kNeoHookean, Law::kOgden),
                                          testing::Values(-0.9, 0.15, 0.45)));

// The stress rotates with the body (the linear law ignores rotations).
TEST(LargeStrainLaws, AreObjective) {
  std::mt19937 engine(5);
  for (const Law kind : {Law::kCorotational, Law::kNeoHookean, Law::kOgden}) {
    const MaterialLaw law(kind, 0.3, kRubber);
    const Matrix3d F = Matrix3d::Identity() + Random(&engine, 0.3);
    const Matrix3d R = Turn({1, 2, 3}, 140);
    const auto still = law.At(F - Matrix3d::Identity());
    const auto turned = law.At(R * F - Matrix3d::Identity());
    EXPECT_LT((turned.stress - R * still.stress).norm(), 1e-13);
    EXPECT_LT((turned.volume_stress - R * still.volume_stress).norm(), 1e-13);
    EXPECT_NEAR(turned.energy, still.energy, 1e-13);
    EXPECT_LT(law.At(R - Matrix3d::Identity()).stress.norm(), 1e-14);
  }
}

// The nodal forces of one element with unit edges, moved by F.
struct OneElement {
  SolidMesh solid{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  TetMesh mesh = MakeTetMesh(solid, 4, 1);
  BlockLayout layout{mesh, false};
  ElasticBody body;
  explicit OneElement(Law law) : body(mesh, layout, MaterialLaw(law, 0.25)) {}

  double Forces(const Matrix3d& F, std::vector<Vector3d>* forces) const {
    VectorXd x(12), gradient(12);
    for (int i = 0; i < 4; ++i) {
      x.segment<3>(layout.first(i)) =
          (F - Matrix3d::Identity()) * mesh.nodes[static_cast<std::size_t>(i)];
    }
    const double energy = body.Energy(x, &gradient);
    for (int i = 0; i < 4; ++i) forces->push_back(gradient.segment<3>(layout.first(i)));
    return energy;
  }
};

// Reference: d_solid3d, inversion and inversion_recovery_apex: forces of the inverted element, and
// its energy V (lambda/2 + mu) (z - 1)^2 along the path; 1e-12.
TEST(InvertedElement, IsPushedBack) {
  PALPATE_CASE_OR_SKIP(apex, "d_solid3d.json", "inversion_recovery_apex");
  PALPATE_CASE_OR_SKIP(states, "d_solid3d.json", "inversion");
  const OneElement element(Law::kCorotational);
  for (const auto& state : states.at("expected")) {
    Matrix3d F;
    for (int i = 0; i < 3; ++i) F.row(i) = VectorOf(state.at("F").at(static_cast<std::size_t>(i)));
    std::vector<Vector3d> forces;
    element.Forces(F, &forces);
    for (const auto& f : forces) EXPECT_TRUE(f.allFinite());
    const bool unique = !state.at("force_signed_svd").is_null() && state.at("name") != "mirror";
    for (std::size_t i = 0; unique && i < 4; ++i) {
      EXPECT_LT((forces[i] - VectorOf(state.at("force_signed_svd").at(i))).norm(), 1e-12)
          << state.at("name");
    }
    if (state.at("name") != "point") {
      EXPECT_LT(forces[3].z(), 0) << state.at("name");
    }
  }
  std::vector<Vector3d> forces;
  const double energy = element.Forces(Vector3d(1, 1, -0.5).asDiagonal(), &forces);
  EXPECT_NEAR(energy, apex.at("expected").at("energy_at_start").get<double>(), 1e-12);
  EXPECT_NEAR(forces[3].z(), apex.at("expected").at("apex_internal_force_z_at_start").get<double>(),
              1e-12);
}

// An irregular mesh around one inner node gets a linear or quadratic displacement field at its
// surface. A quadratic field is balanced by a uniform body force: u = (x^2, 0, 0) c has div sigma =
// 2 c (lambda + 2 mu) e_x. Ten-node elements represent both fields exactly, four-node elements the
// linear one: the error is rounding.
TEST(PatchTest, IsPassedByEveryElement) {
  SolidMesh mesh = MeshBox({1, 1, 1}, {2, 2, 2});
  for (Vector3d& p : mesh.nodes) {
    if (p == Vector3d::Constant(0.5)) p = {0.45, 0.55, 0.4};
  }
  Matrix3d gradient;
  gradient << 0.001, 0.002, -0.001, 0.0005, -0.002, 0.0015, 0.001, -0.0005, 0.003;
  const double c = 1e-3, E = 3800;
  for (const bool quadratic : {false, true}) {
    for (const Element element : {Element::kTet4, Element::kTet10}) {
      for (const double nu : {0.15, 0.495}) {  // from 0.49 on ten nodes have a pressure
        if (quadratic && (element == Element::kTet4 || nu > 0.4)) continue;
        const double modulus = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu));  // lambda + 2 mu
        SolidModel::Params params;
        params.options.element = element;
        params.options.law = Law::kLinear;
        params.young_modulus = E;
        params.poisson_ratio = nu;
        params.density = 1;
        if (quadratic) params.options.gravity_O = {-2 * c * modulus, 0, 0};
        const auto field = [&](const Vector3d& p) -> Vector3d {
          return quadratic ? Vector3d(c * p.x() * p.x(), 0, 0) : Vector3d(gradient * p);
        };
        SolidModel model(mesh, Nothing(mesh), params);
        std::vector<bool> outer(model.mesh().nodes.size(), false);
        for (const auto& t : model.mesh().touch_surface.triangles) {
          for (const int node : t) outer[static_cast<std::size_t>(node)] = true;
        }
        std::vector<Contact> contacts;
        for (std::size_t i = 0; i < outer.size(); ++i) {
          if (outer[i]) {
            contacts.push_back(Move(model.mesh().nodes[i], field(model.mesh().nodes[i])));
          }
        }
        std::vector<ContactResponse> responses(contacts.size());
        model.Respond(contacts, responses);
        ASSERT_NE(responses[0].validity, Validity::kFailed) << model.failure();
        for (int i = 0; i < model.mesh().node_count(); ++i) {
          const Vector3d exact = field(model.mesh().nodes[static_cast<std::size_t>(i)]);
          EXPECT_LT((model.displacement(i) - exact).norm(), 1e-14) << i;
        }
      }
    }
  }
}

}  // namespace
}  // namespace palpate

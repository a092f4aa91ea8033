// Motion: the integrator, eigenfrequencies, energy, and an independent trajectory.
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "shared/geometry/symmetric_eigen.h"
#include "slave/mesh/index.h"
#include "tests/slave/mechanics/direct_solution.h"
#include "tests/slave/mechanics/fem/solids.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using solids::Respond;

FemModel::Params Dynamic(FemModel::Params params, double step) {
  params.options.time = FemOptions::Time::kDynamic;
  params.options.step = step;
  return params;
}

// One node of one tetrahedron that can move along x only, as an oscillator of frequency `omega`.
struct Oscillator {
  explicit Oscillator(double omega)
      : held(4, {true, true, true}), params(solids::Linear(solids::Foam())) {
    held[1] = {false, true, true};
    const double nu = 0.25, V = 1.0 / 6;
    const double share = 0.1;  // consistent mass of a node
    // k = V (lambda + 2 mu) / 1^2 = V E (1 - nu) / ((1 + nu) (1 - 2 nu)), m = share rho V.
    const double per_E = V * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
    params.material = {
        .young_modulus = omega * omega * share * 2 * V / per_E, .poisson_ratio = nu, .density = 2};
    stiffness = params.material.young_modulus * per_E;
  }
  SolidMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  solids::Held held;
  FemModel::Params params;
  double stiffness = 0;
};

// Distances from rest under a constant force, step by step.
std::vector<double> Swing(const Oscillator& body, const FemModel::Params& params, int steps) {
  FemModel model(body.mesh, body.held, params);
  const double force = 1e-3 * body.stiffness;
  std::vector<double> distance;
  for (int i = 0; i < steps; ++i) {
    const auto r = Respond(model, {solids::Push(body.mesh, 1, {force, 0, 0})});
    distance.push_back(r.front().displacement_O.x() - force / body.stiffness);
  }
  return distance;
}

// Reference: implicit Euler of one oscillator obeys (1 + h^2 w^2) e_{n+1} = 2 e_n - e_{n-1}.
TEST(FemMotion, ImplicitEulerFollowsItsRecurrenceAtEveryFrequency) {
  const double h = 1e-3;
  for (const double frequency : {1, 5, 20, 100}) {  // [Hz]
    const double omega = 2 * std::numbers::pi * frequency;
    const Oscillator body(omega);
    auto params = Dynamic(body.params, h);
    const double k = h * h * omega * omega;
    // The body does not rotate, so the co-rotational law gives the same steps.
    for (const auto law : {FemOptions::Law::kLinear, FemOptions::Law::kCorotational}) {
      params.options.law = law;
      const auto e = Swing(body, params, 100);
      for (std::size_t n = 1; n + 1 < e.size(); ++n) {
        EXPECT_NEAR((1 + k) * e[n + 1], 2 * e[n] - e[n - 1], 1e-12 * 1e-3);
      }
    }
  }
}

MatrixXd DenseOf(fem::FemBody& body, double mass, double stiffness) {
  fem::BlockMatrix A(body.pattern());
  body.AssembleTangent(mass, stiffness, A);
  const auto& graph = body.pattern().graph;
  MatrixXd dense = MatrixXd::Zero(3 * body.moving(), 3 * body.moving());
  for (int i = 0; i < body.moving(); ++i) {
    int k = graph.begin[Index(i)];
    for (const int j : graph.of(i)) {
      dense.block<3, 3>(3 * i, 3 * j) = Eigen::Map<const Matrix3d>(A.block(k++));
    }
  }
  return dense;
}

// Eigenvalues of K x = w^2 M x, ascending.
VectorXd SquaredFrequencies(const MatrixXd& K, const MatrixXd& M) {
  const Eigen::LLT<MatrixXd> root(M);
  const MatrixXd half = root.matrixL().solve(K);
  return EigenOf(root.matrixL().solve(half.transpose())).values;
}

// Reference d, bar_eigenfrequencies_discrete: the first six of K x = w^2 M x, dense.
TEST(FemMotion, TheClampedBarHasItsDiscreteEigenfrequencies) {
  PALPATE_CASE_OR_SKIP(given, "d_solid3d.json", "bar_eigenfrequencies_discrete");
  const auto& p = given.at("params");
  const double L = p.at("L"), w = p.at("w"), E = p.at("E"), rho = p.at("rho");
  const SolidMesh mesh = MeshBox({L, w, w}, {10, 2, 2});
  const auto held = FixedWhere(mesh, [](const Vector3d& x) { return x.x() < 1e-9; });
  fem::FemBody body(mesh, held,
                    {.poisson_ratio = p.at("nu"), .law = fem::TetElements::Law::kLinear});
  const VectorXd squares = SquaredFrequencies(DenseOf(body, 0, 1), DenseOf(body, 1, 0));
  const auto& expected = given.at("expected").at("consistent_mass_hz");
  const double unit = std::sqrt(E / rho) / body.length_unit() / (2 * std::numbers::pi);
  for (std::size_t i = 0; i < 6; ++i) {
    const double f = unit * std::sqrt(squares[static_cast<Eigen::Index>(i)]);
    EXPECT_NEAR(f / expected.at(i).get<double>(), 1, 1e-8) << "mode " << i;
  }
}

// The time step of the public co-rotational codes with dense matrices: singular values instead of
// quaternions, Lame's law by strains in Voigt's notation, the whole system by LU.
class DenseTrajectory {
 public:
  DenseTrajectory(const SolidMesh& mesh, const solids::Held& held, const FemModel::Params& params)
      : mesh_(mesh), held_(held), params_(params) {
    const auto n = static_cast<Eigen::Index>(3 * mesh.nodes.size());
    u_ = v_ = VectorXd::Zero(n);
  }

  void Step(const VectorXd& f_ext) {
    const double h = params_.options.step;
    Assemble();
    MatrixXd A = M_ + h * h * K_;
    VectorXd rhs = h * (f_ext - f_ - h * K_ * v_);
    for (std::size_t i = 0; i < held_.size(); ++i) {
      if (!held_[i][0]) continue;
      for (int c = 0; c < 3; ++c) {
        const auto d = static_cast<Eigen::Index>(3 * i) + c;
        A.row(d).setZero();
        A.col(d).setZero();
        A(d, d) = 1;
        rhs[d] = 0;
      }
    }
    v_ += A.partialPivLu().solve(rhs);
    u_ += h * v_;
  }
  [[nodiscard]] const VectorXd& u() const { return u_; }

 private:
  void Assemble() {
    K_ = M_ = MatrixXd::Zero(u_.size(), u_.size());
    f_ = VectorXd::Zero(u_.size());
    for (const auto& tet : mesh_.tets) AddElement(tet);
  }

  void AddElement(const std::array<int, 4>& tet) {
    Matrix3d edges, moved;
    Eigen::Matrix<double, 12, 1> X, x;
    for (int i = 0; i < 4; ++i) {
      const int node = tet[Index(i)];
      X.segment<3>(3 * i) = mesh_.nodes[Index(node)];
      x.segment<3>(3 * i) = X.segment<3>(3 * i) + u_.segment<3>(3 * node);
      if (i == 0) continue;
      edges.col(i - 1) = X.segment<3>(3 * i) - X.head<3>();
      moved.col(i - 1) = x.segment<3>(3 * i) - x.head<3>();
    }
    const double V = edges.determinant() / 6;
    const Matrix3d F = moved * edges.inverse();
    const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
    const Matrix3d R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    Eigen::Matrix<double, 12, 12> R4 = Eigen::Matrix<double, 12, 12>::Zero();
    for (int i = 0; i < 4; ++i) R4.block<3, 3>(3 * i, 3 * i) = R;
    const Eigen::Matrix<double, 12, 12> K0 =
        VoigtStiffness(mesh_, tet, params_.material.young_modulus, params_.material.poisson_ratio);
    const Eigen::Matrix<double, 12, 12> K = R4 * K0 * R4.transpose();
    const Eigen::Matrix<double, 12, 1> f = R4 * K0 * (R4.transpose() * x - X);
    for (int i = 0; i < 4; ++i) {
      const int row = 3 * tet[Index(i)];
      f_.segment<3>(row) += f.segment<3>(3 * i);
      for (int j = 0; j < 4; ++j) {
        const int column = 3 * tet[Index(j)];
        K_.block<3, 3>(row, column) += K.block<3, 3>(3 * i, 3 * j);
        M_.block<3, 3>(row, column) +=
            params_.material.density * V / (i == j ? 10 : 20) * Matrix3d::Identity();
      }
    }
  }

  const SolidMesh& mesh_;
  const solids::Held& held_;
  FemModel::Params params_;
  MatrixXd K_, M_;
  VectorXd u_, v_, f_;
};

// Reference: DenseTrajectory. With a residual of 1e-12 the error is 1e-9 of the displacement; with
// the default of 1e-6 it is less than 1e-6.
TEST(FemMotion, OneLinearSolvePerStepFollowsTheIndependentTrajectory) {
  const SolidMesh mesh = MeshBox({0.06, 0.06, 0.06}, {3, 2, 2});
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() < 1e-9; });
  auto params = Dynamic(solids::Foam(), 0.02);
  const int node = solids::NodeAt(mesh, {0.06, 0.03, 0.06});
  for (const auto& [residual, tolerance] : {std::pair{1e-12, 1e-9}, {1e-6, 1e-6}}) {
    params.options.residual = residual;
    FemModel model(mesh, held, params);
    DenseTrajectory dense(mesh, held, params);
    VectorXd f = VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
    for (int step = 1; step <= 30; ++step) {
      const Vector3d force = Vector3d(-0.3, 0.2, -0.4) * std::min(1.0, step / 10.0);
      f.segment<3>(3 * node) = force;
      dense.Step(f);
      const auto r = Respond(model, {solids::Push(mesh, node, force)});
      const Vector3d expected = dense.u().segment<3>(3 * node);
      EXPECT_LT((r.front().displacement_O - expected).norm(), tolerance * expected.norm())
          << "step " << step;
    }
    EXPECT_GT(dense.u().segment<3>(3 * node).norm(), 0.01);  // far from small
  }
}

// Law: energy that steps gain is reported. The energy of a released body never grows. One linear
// solve per step, with the tangent of the step's start, does not guarantee this for a bar that
// swings far. The same motion in the linear law gains nothing.
TEST(FemMotion, EnergyFromNowhereIsFlagged) {
  const SolidMesh mesh = MeshBox({0.12, 0.03, 0.03}, {8, 2, 2});
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() < 1e-9; });
  const int tip = solids::NodeAt(mesh, {0.12, 0.015, 0.03});
  struct Count {
    int jumps = 0, flagged = 0;
  };
  const auto swing = [&](const FemModel::Params& params, double push, int steps) {
    FemModel model(mesh, held, params);
    for (int i = 0; i < steps / 20; ++i) {
      Respond(model, {solids::Push(mesh, tip, {-push, 0.2 * push, push})});
    }
    Respond(model, {solids::Push(mesh, tip, {0, 0, 0})});
    double before = model.energy();
    Count count;
    for (int i = 0; i < steps; ++i) {
      const auto r = Respond(model, {solids::Push(mesh, tip, {0, 0, 0})}).front();
      if (r.validity == Validity::kFailed) break;  // it has grown too much for one step
      const bool jumped = model.energy() > before * 1.01;
      const bool is_flagged = model.stepper()->gained_energy();
      count.jumps += jumped ? 1 : 0;
      count.flagged += is_flagged ? 1 : 0;
      EXPECT_TRUE(!jumped || is_flagged) << "step " << i;
      EXPECT_TRUE(!is_flagged || r.validity == Validity::kExtrapolated) << "step " << i;
      before = model.energy();
    }
    return count;
  };
  auto params = Dynamic(solids::Foam(), 0.02);
  EXPECT_GT(swing(params, 0.3, 100).jumps, 0);
  EXPECT_EQ(swing(solids::Linear(params), 0.001, 100).flagged, 0);
}

// Reference: the static answer. Implicit Euler damps a motion, the more the longer the step, so it
// ends there.
TEST(FemMotion, MotionSettlesInTheStaticEquilibrium) {
  const SolidMesh mesh = MeshBox({0.06, 0.06, 0.06}, {3, 3, 3});
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() < 1e-9; });
  const Contact patch = contacts::Move({0.06, 0.03, 0.03}, {-0.01, 0.004, 0});
  FemModel still(mesh, held, solids::Foam());
  Solution at_rest, at_end;
  const auto expected = Respond(still, {patch}, &at_rest).front();
  ASSERT_NE(expected.validity, Validity::kFailed) << still.failure();
  FemModel moving(mesh, held, Dynamic(solids::Foam(), 0.05));
  ContactResponse response;
  for (int i = 0; i < 200; ++i) response = Respond(moving, {patch}, &at_end).front();
  EXPECT_LT((response.force_O - expected.force_O).norm(), 1e-6 * expected.force_O.norm())
      << moving.failure();
  EXPECT_LT(solids::Difference(solids::Displacement(moving, at_end),
                               solids::Displacement(still, at_rest)),
            1e-6);
}

// Law: after a step that fails the body moves on as if that step had not been requested, also where
// the failure is found in the state at its end.
TEST(FemMotion, AFailedStepLeavesTheMotionAsItWas) {
  constexpr double kEdge = 0.06;
  const SolidMesh mesh = MeshBox({kEdge, kEdge, kEdge}, {4, 4, 4});
  const auto held = FixedWhere(mesh, [](const Vector3d& p) { return p.z() == 0; });
  const Vector3d top(kEdge / 2, kEdge / 2, kEdge);
  for (const auto& params : {solids::Linear(solids::Foam()), solids::Foam()}) {
    FemModel interrupted(mesh, held, Dynamic(params, 0.01)),
        steady(mesh, held, Dynamic(params, 0.01));
    // Slightly below the force that is refused at once; a soft node moves farther than accepted.
    const double most = 0.9e6 * params.material.young_modulus * kEdge * kEdge;
    for (int k = 1; k <= 6; ++k) {
      if (k == 4) {
        const Contact absurd = contacts::Push(top, {0, 0, most});
        EXPECT_EQ(Respond(interrupted, {absurd}).front().validity, Validity::kFailed);
        EXPECT_NE(interrupted.failure(), "the time step did not converge");
      }
      const Contact press = contacts::Push(top, {0, 0, -0.02 * k});
      const ContactResponse is = Respond(interrupted, {press}).front(),
                            should = Respond(steady, {press}).front();
      ASSERT_EQ(is.validity, should.validity) << k << ": " << interrupted.failure();
      EXPECT_LT((is.displacement_O - should.displacement_O).norm(),
                1e-6 * should.displacement_O.norm())
          << k;
    }
  }
}

}  // namespace
}  // namespace palpate

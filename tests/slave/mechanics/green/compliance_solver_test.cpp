#include "slave/mechanics/capacitance/compliance_solver.h"

#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kPlaces = 90;
constexpr double kUnit = 0.02;  // [m]
constexpr double kE = 4000;     // [Pa]
constexpr int kHeldPlace = 40;  // its third component is held

// A made-up body: a positive definite matrix that decays with the distance of the places' numbers,
// as compliances do, with a skew part if asked for.
class MadeUp final : public Compliance {
 public:
  explicit MadeUp(bool symmetric) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> side(-1, 1);
    const int n = 3 * kPlaces;
    const auto R = MatrixXd::NullaryExpr(n, n, [&] { return side(random); }).eval();
    full = 0.5 * R * R.transpose() / n + 0.1 * MatrixXd::Identity(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) full(i, j) += 1.0 / (1 + std::abs(i / 3 - j / 3));
    }
    if (!symmetric) full += 0.3 * (R - R.transpose()) / std::sqrt(n);
    full.row(3 * kHeldPlace + 2).setZero();
    full.col(3 * kHeldPlace + 2).setZero();
    for (int p = 0; p < kPlaces; ++p) {
      std::vector<double> column;
      for (int i = 0; i < kPlaces; ++i) {
        for (int c = 0; c < 3; ++c) {
          for (int r = 0; r < 3; ++r) column.push_back(full(3 * i + r, 3 * p + c));
        }
      }
      columns_.push_back(column);
    }
  }
  [[nodiscard]] int places() const override { return kPlaces; }
  const double* Column(int place) override {
    return place == missing ? nullptr : columns_[static_cast<std::size_t>(place)].data();
  }
  [[nodiscard]] double length_unit() const override { return kUnit; }
  [[nodiscard]] std::size_t memory_bytes() const override { return 0; }

  MatrixXd full;
  int missing = -1;

 private:
  std::vector<std::vector<double>> columns_;
};

// `element` is the first place, `width` how many more; p_O.x() > 0: a point between two with that
// share of the second.
class Numbered final : public ContactPlaces {
 public:
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override {
    ++calls;
    if (contact.element < 0 || contact.element >= kPlaces) return "there is no such place";
    footprint->places.clear();
    footprint->normal_O = Vector3d(1, 2, -2) / 3;
    footprint->point = contact.width == 0;
    const double share = contact.p_O.x();
    if (share > 0) {
      footprint->places = {{contact.element, 1 - share}, {contact.element + 1, share}};
      return {};
    }
    const int count = 1 + static_cast<int>(contact.width);
    for (int k = 0; k < count; ++k) footprint->places.push_back({contact.element + k, 1.0 / count});
    return {};
  }
  int calls = 0;
};

Contact At(int place, const Vector3d& moved, double width = 0, double share = 0) {
  Contact contact;
  contact.element = place;
  contact.width = width;
  contact.p_O.x() = share;
  contact.prescribed_O = kUnit * moved;
  return contact;
}
Contact LoadAt(int place, const Vector3d& force, double width = 0, double share = 0) {
  Contact contact = At(place, force, width, share);
  contact.kind = Contact::Kind::kForce;
  contact.prescribed_O = kE * kUnit * kUnit * force;
  return contact;
}

struct Expected {
  VectorXd u;
  std::vector<Vector3d> force, moved;  // [N], [m]
};

// Reference: the stiffness (the inverse of all of the compliance, which the solver never takes)
// with Lagrange multipliers.
Expected Solve(const MatrixXd& compliance, std::span<const Contact> contacts, bool frictionless) {
  Numbered numbered;
  std::vector<ContactFootprint> footprints;
  std::vector<std::tuple<VectorXd, double, std::size_t, Vector3d>> rows;
  const auto n = compliance.rows();
  VectorXd load = VectorXd::Zero(n);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    auto& footprint = footprints.emplace_back();
    numbered.Find(contact, &footprint);
    if (contact.kind == Contact::Kind::kForce) {
      for (const auto& [p, w] : footprint.places)
        load.segment<3>(3 * p) += w * contact.prescribed_O;
      continue;
    }
    std::vector<Vector3d> directions{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    if (frictionless) directions = {footprint.normal_O};
    for (const auto& direction : directions) {
      VectorXd together = VectorXd::Zero(n);
      for (const auto& [p, w] : footprint.places) {
        VectorXd alone = VectorXd::Zero(n);
        alone.segment<3>(3 * p) = direction;
        together += w * alone;
        if (!footprint.point)
          rows.emplace_back(alone, direction.dot(contact.prescribed_O), i, direction);
      }
      if (footprint.point) {
        rows.emplace_back(together, direction.dot(contact.prescribed_O), i, direction);
      }
    }
  }
  MatrixXd free = compliance;  // a held component gets a compliance of its own that nobody sees
  free(3 * kHeldPlace + 2, 3 * kHeldPlace + 2) = 1;
  const MatrixXd K = (free / (kE * kUnit)).inverse();
  const double scale = kE * kUnit;
  const auto m = static_cast<Eigen::Index>(rows.size());
  MatrixXd A = MatrixXd::Zero(n + m, n + m);
  VectorXd b = VectorXd::Zero(n + m);
  A.topLeftCorner(n, n) = K;
  b.head(n) = load;
  for (Eigen::Index k = 0; k < m; ++k) {
    const auto& [row, value, contact, direction] = rows[static_cast<std::size_t>(k)];
    A.row(n + k).head(n) = scale * row;
    A.col(n + k).head(n) = -scale * row;
    b[n + k] = scale * value;
  }
  const VectorXd x = A.partialPivLu().solve(b);
  Expected expected{x.head(n), {}, {}};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    Vector3d force = Vector3d::Zero(), moved = Vector3d::Zero();
    for (Eigen::Index k = 0; k < m; ++k) {
      const auto& [row, value, contact, direction] = rows[static_cast<std::size_t>(k)];
      if (contact == i) force += scale * x[n + k] * direction;
    }
    for (const auto& [p, w] : footprints[i].places) moved += w * x.segment<3>(3 * p);
    const bool load_given = contacts[i].kind == Contact::Kind::kForce;
    expected.force.push_back(load_given ? contacts[i].prescribed_O : force);
    expected.moved.push_back(load_given ? moved : contacts[i].prescribed_O);
  }
  return expected;
}

class ComplianceSolverTest : public testing::TestWithParam<bool> {
 protected:
  void ExpectSame(ComplianceSolver& solver, std::span<const Contact> contacts, bool frictionless,
                  double tolerance) {
    std::vector<ContactResponse> got(contacts.size());
    solver.Respond(contacts, got);
    const Expected expected = Solve(body_.full, contacts, frictionless);
    double force = 0;
    for (const auto& f : expected.force) force = std::max(force, f.norm());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      ASSERT_FALSE(got[i].validity == Validity::kFailed) << solver.failure();
      EXPECT_LT((got[i].force_O - expected.force[i]).norm(), tolerance * force) << i;
      EXPECT_LT((got[i].displacement_O - expected.moved[i]).norm(), tolerance * kUnit) << i;
    }
    std::vector<Vector3d> field;
    solver.Displacement(&field);
    for (int p = 0; p < kPlaces; ++p) {
      Vector3d u = expected.u.segment<3>(3 * p);
      if (p == kHeldPlace) u.z() = 0;
      EXPECT_LT((field[static_cast<std::size_t>(p)] - u).norm(), tolerance * kUnit) << p;
    }
  }
  MadeUp body_{GetParam()};
  Numbered places_;
  ComplianceSolver::Params params_{.young_modulus = kE, .larger_side = kUnit, .range = 10};
};

// Condition numbers are below 1e4: 1e-11 leaves a digit.
TEST_P(ComplianceSolverTest, EveryKindOfContactTogetherIsAnswered) {
  ComplianceSolver solver(body_, places_, params_);
  const std::vector<Contact> contacts{
      At(3, {0.1, -0.2, 0.3}),
      At(10, {0.2, 0.1, -0.1}, 4),
      LoadAt(20, {0.3, -0.1, 0.2}),
      At(25, {-0.1, 0.1, 0.2}, 0, 0.3),
      LoadAt(30, {-0.2, 0.2, 0.1}, 6),
      LoadAt(32, {0.1, 0, 0}, 3),
      LoadAt(50, {0, 0.1, 0.2}, 0, 0.6),
      LoadAt(13, {0.1, 0.1, 0}, 3)};  // the last partly under a contact
  for (std::size_t n = 1; n <= contacts.size(); ++n) {
    ExpectSame(solver, std::span(contacts).first(n), false, 1e-11);
  }
  params_.contact = ContactLaw::kFrictionless;
  ComplianceSolver slippery(body_, places_, params_);
  for (std::size_t n = 1; n <= contacts.size(); ++n) {
    std::vector<ContactResponse> got(n);
    slippery.Respond(std::span(contacts).first(n), got);
    ExpectSame(slippery, std::span(contacts).first(n), true, 1e-11);
  }
}

// Reference: the differences of the answers, exact for a linear body. The stiffness of a wide patch
// alone is found by solving, not from blocks of the inverse.
TEST_P(ComplianceSolverTest, StiffnessIsTheDerivative) {
  ComplianceSolver solver(body_, places_, params_);
  const std::vector<Contact> several{At(3, {0.1, -0.2, 0.3}), At(10, {0.2, 0.1, -0.1}, 4),
                                     LoadAt(20, {0.3, -0.1, 0.2}), LoadAt(30, {-0.2, 0.2, 0.1}, 6)};
  for (const auto& contacts : {several, std::vector{At(10, {0.2, 0.1, -0.1}, 19)}}) {
    std::vector<ContactResponse> before(contacts.size()), after(contacts.size());
    solver.Respond(contacts, before);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        auto moved = contacts;
        moved[i].prescribed_O[c] += moved[i].prescribed_O.norm();
        solver.Respond(moved, after);
        const Vector3d df = after[i].force_O - before[i].force_O;
        const Vector3d du = after[i].displacement_O - before[i].displacement_O;
        EXPECT_LT((before[i].stiffness_O * du - df).norm(), 1e-10 * df.norm());
      }
    }
  }
}

// Reference: the same contacts of a solver that is asked for all at once.
TEST_P(ComplianceSolverTest, StiffnessIsFoundWhenItIsFirstWanted) {
  ComplianceSolver solver(body_, places_, params_), other(body_, places_, params_);
  std::vector<Contact> contacts{At(3, {0.1, -0.2, 0.3}), At(10, {0.2, 0.1, -0.1}, 4),
                                LoadAt(20, {0.3, -0.1, 0.2}), At(25, {-0.1, 0.1, 0.2}, 0, 0.3)};
  std::vector<ContactResponse> got(contacts.size()), expected(contacts.size());
  other.Respond(contacts, expected);
  for (auto& contact : contacts) contact.wants_stiffness = false;
  solver.Respond(contacts, got);
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_TRUE(got[i].stiffness_O.isZero(0)) << i;
    EXPECT_EQ(got[i].force_O, expected[i].force_O) << i;
  }
  for (auto& contact : contacts) contact.wants_stiffness = true;
  solver.Respond(contacts, got);
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_TRUE(got[i].stiffness_O.isApprox(expected[i].stiffness_O, 1e-12)) << i;
  }
}

// Contacts come, go and move one at a time, ten thousand times; every hundredth answer is held to a
// solver that has seen nothing before.
TEST_P(ComplianceSolverTest, TenThousandUpdatesAgreeWithAFreshSolver) {
  ComplianceSolver solver(body_, places_, params_);
  std::mt19937 random(23);
  const auto dice = [&](std::size_t sides) { return random() % sides; };
  std::vector<int> spare;
  for (int p = 0; p < kPlaces; ++p) {
    if (p != kHeldPlace) spare.push_back(p);
  }
  std::vector<Contact> contacts;
  const auto take = [&] {
    const std::size_t k = dice(spare.size());
    std::swap(spare[k], spare.back());
    Contact contact = At(spare.back(), {0.01 * static_cast<double>(dice(30)), -0.1, 0.2});
    spare.pop_back();
    if (dice(10) == 0) contact.kind = Contact::Kind::kForce;
    return contact;
  };
  double worst = 0;
  for (int step = 0; step < 10000; ++step) {
    const std::size_t choice = dice(10);
    const std::size_t at = contacts.empty() ? 0 : dice(contacts.size());
    if (contacts.size() < 2 || (choice < 2 && contacts.size() < 40)) {
      contacts.insert(contacts.begin() + static_cast<long>(at), take());
    } else if (choice < 4) {
      spare.push_back(contacts[at].element);
      contacts.erase(contacts.begin() + static_cast<long>(at));
    } else {
      const Contact next = take();
      spare.push_back(contacts[at].element);
      contacts[at] = next;
    }
    std::vector<ContactResponse> got(contacts.size()), fresh(contacts.size());
    solver.Respond(contacts, got);
    ASSERT_FALSE(got[0].validity == Validity::kFailed) << solver.failure();
    if (step % 100 != 0) continue;
    ComplianceSolver other(body_, places_, params_);
    other.Respond(contacts, fresh);
    for (std::size_t i = 0; i < got.size(); ++i) {
      const double force = (got[i].force_O - fresh[i].force_O).norm() / fresh[i].force_O.norm();
      const double moved = (got[i].displacement_O - fresh[i].displacement_O).norm() / kUnit;
      worst = std::max({worst, force, moved});
    }
  }
  EXPECT_LT(worst, 1e-9);
}

TEST_P(ComplianceSolverTest, LooksOnlyForPlacesOfContactsThatChanged) {
  ComplianceSolver solver(body_, places_, params_);
  std::vector<Contact> contacts{At(3, {0.1, 0, 0}), At(10, {0.1, 0, 0}), At(20, {0.1, 0, 0})};
  std::vector<ContactResponse> responses(3);
  solver.Respond(contacts, responses);
  contacts[1].prescribed_O *= 2;
  solver.Respond(contacts, responses);
  EXPECT_EQ(places_.calls, 3);
  contacts[1].element = 11;
  solver.Respond(contacts, responses);
  EXPECT_EQ(places_.calls, 4);
  solver.Respond(std::span(contacts).first(2), responses);  // not even an answer: sizes differ
  EXPECT_EQ(responses[0].validity, Validity::kFailed);
}

TEST_P(ComplianceSolverTest, HeldComponentsAreNoUnknownsAndMissingColumnsAreReported) {
  ComplianceSolver solver(body_, places_, params_);
  const std::vector<Contact> beside{At(kHeldPlace, {0.1, 0.2, 0}), At(60, {0.1, 0, 0})};
  ExpectSame(solver, beside, false, 1e-11);
  std::vector<ContactResponse> response(1);
  solver.Respond(std::vector<Contact>{At(kHeldPlace, {0, 0, 0.1})}, response);
  EXPECT_EQ(response[0].validity, Validity::kFailed);
  EXPECT_THAT(std::string(solver.failure()), testing::HasSubstr("fixed point"));
  solver.Respond(std::vector<Contact>{LoadAt(kHeldPlace, {0, 0, 0.1})}, response);
  EXPECT_EQ(response[0].validity, Validity::kFailed);
  body_.missing = 7;
  for (const Contact& contact : {At(7, {0.1, 0, 0}), LoadAt(7, {0.1, 0, 0})}) {
    solver.Respond({&contact, 1}, response);
    EXPECT_EQ(response[0].validity, Validity::kFailed);
    EXPECT_THAT(std::string(solver.failure()), testing::HasSubstr("memory"));
  }
  std::vector<PlaceForce> forces;
  solver.Forces(&forces);
  EXPECT_TRUE(forces.empty());
  ExpectSame(solver, beside, false, 1e-11);
}

TEST(ComplianceSolver, RefusesParametersThatMakeNoSense) {
  MadeUp body(true);
  Numbered places;
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(ComplianceSolver(body, places, {.young_modulus = bad, .larger_side = 1}),
                 std::invalid_argument);
    EXPECT_THROW(ComplianceSolver(body, places, {.young_modulus = 1, .larger_side = bad}),
                 std::invalid_argument);
    EXPECT_THROW(
        ComplianceSolver(body, places, {.young_modulus = 1, .larger_side = 1, .range = bad}),
        std::invalid_argument);
  }
}

INSTANTIATE_TEST_SUITE_P(Symmetry, ComplianceSolverTest, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "Symmetric" : "General"; });

}  // namespace
}  // namespace palpate

// Tests the requirements of deformation_model.h with every kind of model. A new kind is added by
// one line in TestedKinds().
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "tests/slave/mechanics/bodies.h"
#include "tests/support/allocation_count.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Element = FemOptions::Element;
using Law = FemOptions::Law;
using Model = std::unique_ptr<DeformationModel>;

// Two places of contact, one that is fixed, and a displacement, in body sizes.
struct Presses {
  Vector3d p_O, other_p_O, fixed_O, direction;
  double depth = 0.002;
};
const Presses kOnCube{{0.5, 0.5, 1}, {0.25, 0.5, 1}, {0.5, 0.5, 0}, {0.1, 0.05, -1}};
const Presses kOnBlock{{0.52, 1, 0}, {0.21, 1, 0}, {0.52, 0, 0}, {0.1, -1, 0}};
const Presses kOnDisc{{0.05, 0, 0}, {-0.2, 0.1, 0}, {0.5, 0, 0}, {0, 0, -1}, 1e-4};

struct TestedKind {
  std::string name;
  const Presses* presses;
  bool is_linear;
  // Relative difference of answers that should be equal: rounding if a factor is used; with
  // iterations the residual of 1e-10 times the condition of these bodies (up to 1e3).
  double tolerance;
  // A body of this size [m] and Young's modulus [Pa].
  std::function<Model(double size, double modulus)> make;
  // Relative difference between a load and a displacement at the same place, and between the works
  // of two loads, if the stiffness of the discretisation is not symmetric (collocation).
  double asymmetry = 0;
};
void PrintTo(const TestedKind& kind, std::ostream* out) {
  *out << kind.name;
}

struct CubeBody {
  SolidMesh mesh;
  HeldNodes held;  // supports: the bottom
};
CubeBody MakeCube(double size) {
  const SolidMesh mesh = MeshBox({size, size, size}, {4, 4, 4});
  return {mesh, FixedWhere(mesh, [&](const Vector3d& p) { return p.z() < 1e-6 * size; })};
}

TestedKind Bem2d(const char* name, ElementOrder order, Plane plane = Plane::kStress,
                 ContactLaw contact = ContactLaw::kBonded) {
  return {name,
          &kOnBlock,
          true,
          1e-9,
          [=](double size, double modulus) -> Model {
            ReferenceProblem problem = bodies::Block(60, size, 0.4, plane);
            problem.order = order;
            return std::make_unique<Bem2dModel>(
                problem,
                Bem2dModel::Params{
                    .young_modulus = modulus, .thickness = 0.1 * size, .contact = contact});
          },
          0.03};
}

TestedKind Fem(const char* name, Law law) {
  return {name, &kOnCube, law == Law::kLinear, 1e-7, [=](double size, double modulus) -> Model {
            FemModel::Params params{
                .material = {.young_modulus = modulus, .poisson_ratio = 0.3, .density = 0},
                .options = {.law = law, .residual = 1e-10},
                .range = 0.1};
            const CubeBody cube = MakeCube(size);
            return std::make_unique<FemModel>(cube.mesh, cube.held, params);
          }};
}

TestedKind Solid(const char* name, Element element, Law law, double nu = 0.3) {
  return {name, &kOnCube, law == Law::kLinear, 1e-7, [=](double size, double modulus) -> Model {
            SolidModel::Params params{
                .options = {.element = element, .law = law, .residual = 1e-10},
                .young_modulus = modulus,
                .poisson_ratio = nu};
            const CubeBody cube = MakeCube(size);
            return std::make_unique<SolidModel>(cube.mesh, cube.held, params);
          }};
}

TestedKind Green(const char* name, FemOptions::Element element, double nu = 0.3,
                 ContactLaw contact = ContactLaw::kBonded) {
  return {name, &kOnCube, true, 1e-9, [=](double size, double modulus) -> Model {
            const CubeBody cube = MakeCube(size);
            return std::make_unique<FemGreenModel>(
                cube.mesh, cube.held, modulus, nu,
                FemGreenModel::Options{.element = element, .contact = contact});
          }};
}

TestedKind Plate() {
  return {
      "plate", &kOnDisc, true, 1e-9, [](double size, double modulus) -> Model {
        return std::make_unique<PlateModel>(PlateModel::Params{size / 2, size / 50, modulus, 0.4});
      }};
}

TestedKind PlateLarge() {
  return {"plate-large", &kOnDisc, false, 1e-6, [](double size, double modulus) -> Model {
            return std::make_unique<PlateLargeModel>(
                PlateLargeModel::Params{size / 2, size / 50, modulus, 0.4});
          }};
}

std::vector<TestedKind> TestedKinds() {
  return {
      Bem2d("bem2d-constant", ElementOrder::kConstant),
      Bem2d("bem2d-linear", ElementOrder::kLinear),
      Bem2d("bem2d-quadratic", ElementOrder::kQuadratic, Plane::kStrain),
      Fem("fem-linear", Law::kLinear),
      Fem("fem-corotational", Law::kCorotational),
      Fem("fem-neo-hookean", Law::kNeoHookean),
      Solid("fem-tet10-linear", Element::kTet10, Law::kLinear),
      Solid("fem-tet10-linear-mixed", Element::kTet10, Law::kLinear, 0.499),
      Solid("fem-tet10-neo-hookean", Element::kTet10, Law::kNeoHookean),
      Solid("fem-tet4-neo-hookean", Element::kTet4, Law::kNeoHookean),
      Green("fem-green-tet4", FemOptions::Element::kTet4),
      Green("fem-green-tet10", FemOptions::Element::kTet10),
      Green("fem-green-tet10-mixed", FemOptions::Element::kTet10, 0.499),
      Plate(),
      PlateLarge(),
  };
}

std::vector<TestedKind> FrictionlessKinds() {
  const auto law = ContactLaw::kFrictionless;
  return {Bem2d("bem2d-constant", ElementOrder::kConstant, Plane::kStress, law),
          Bem2d("bem2d-quadratic", ElementOrder::kQuadratic, Plane::kStress, law),
          Green("fem-green-tet4", Element::kTet4, 0.3, law),
          Green("fem-green-tet10", Element::kTet10, 0.3, law),
          Green("fem-green-tet10-mixed", Element::kTet10, 0.499, law)};
}

class Conformance : public testing::TestWithParam<TestedKind> {
 protected:
  static constexpr double kSize = 0.06;    // [m]
  static constexpr double kModulus = 3e4;  // [Pa]

  [[nodiscard]] Model Make(double size = kSize, double modulus = kModulus) const {
    return GetParam().make(size, modulus);
  }
  static Contact At(const Vector3d& place, Contact::Kind kind, const Vector3d& value,
                    double size = kSize) {
    return {.kind = kind, .p_O = size * place, .prescribed_O = value};
  }
  // Returns a displacement at the first place, `factor` times the usual depth.
  [[nodiscard]] Contact Move(double factor = 1, double size = kSize) const {
    const Presses& p = *GetParam().presses;
    return At(p.p_O, Contact::Kind::kDisplacement, factor * p.depth * size * p.direction, size);
  }
  [[nodiscard]] Contact MoveOther(double factor = 1) const {
    const Presses& p = *GetParam().presses;
    return At(p.other_p_O, Contact::Kind::kDisplacement, factor * p.depth * kSize * p.direction);
  }
  static std::vector<ContactResponse> Answer(DeformationModel& model,
                                             const std::vector<Contact>& contacts) {
    std::vector<ContactResponse> responses(contacts.size());
    model.Respond(contacts, responses);
    return responses;
  }
  static Vector3d ForceOf(DeformationModel& model, const Contact& contact) {
    return Answer(model, {contact}).front().force_O;
  }
  [[nodiscard]] double tolerance() const { return GetParam().tolerance; }
};

void ExpectNear(const Vector3d& a, const Vector3d& b, double tolerance) {
  EXPECT_LE((a - b).norm(), tolerance) << a.transpose() << " against " << b.transpose();
}

TEST_P(Conformance, NoDisplacementNeedsNoForce) {
  const Model model = Make();
  const double scale = ForceOf(*model, Move()).norm();
  const ContactResponse response = Answer(*model, {Move(0)}).front();
  EXPECT_NE(response.validity, Validity::kFailed);
  EXPECT_LE(response.force_O.norm(), tolerance() * scale);
}

TEST_P(Conformance, NoContactIsNoFailure) {
  const Model model = Make();
  Solution solution;
  model->Solve({}, &solution);
  EXPECT_TRUE(solution.responses().empty());
  EXPECT_EQ(model->failure(), "");
  std::vector<Vector3d> u_O;
  model->Displacements(solution, &u_O);
  EXPECT_EQ(u_O.size(), model->field_mesh().vertices.size());
  for (const Vector3d& u : u_O) EXPECT_LE(u.norm(), 1e-12 * kSize);
}

TEST_P(Conformance, ALoadInvertsADisplacement) {
  const Model model = Make();
  for (const Contact& contact : {Move(), MoveOther()}) {
    const ContactResponse moved = Answer(*model, {contact}).front();
    ASSERT_EQ(moved.validity, Validity::kValid) << model->failure() << moved.flag_reason;
    EXPECT_GT(moved.force_O.dot(moved.displacement_O), 0);
    Contact load = contact;
    load.kind = Contact::Kind::kForce;
    load.prescribed_O = moved.force_O;
    const ContactResponse loaded = Answer(*model, {load}).front();
    ASSERT_EQ(loaded.validity, Validity::kValid) << model->failure();
    ExpectNear(loaded.force_O, moved.force_O, tolerance() * moved.force_O.norm());
    ExpectNear(loaded.displacement_O, moved.displacement_O,
               (10 * tolerance() + GetParam().asymmetry) * moved.displacement_O.norm());
  }
}

// Reference: central differences, whose error is that of the second order of a strain of 1e-5.
TEST_P(Conformance, AStatedStiffnessIsTheDerivativeOfTheForce) {
  const Model model = Make();
  const ContactResponse response = Answer(*model, {Move(), MoveOther()}).front();
  if (response.stiffness_O.isZero(0)) return;  // this kind gives no stiffness
  for (const double side : {0.0, 1.0}) {  // along the press, and tangentially if this has a force
    Vector3d step = 1e-3 * Move().prescribed_O;
    if (side > 0) step = Vector3d(step.z(), 0, -step.x());
    if (side > 0 && response.force_O.head<2>().isZero(0)) continue;
    Contact more = Move(), less = Move();
    more.prescribed_O += step, less.prescribed_O -= step;
    const Vector3d change = Answer(*model, {more, MoveOther()}).front().force_O -
                            Answer(*model, {less, MoveOther()}).front().force_O;
    const Vector3d expected = 2 * (response.stiffness_O * step);
    ExpectNear(change, expected, 1e-3 * expected.norm() + 1e-9 * response.force_O.norm());
  }
}

// Betti: the work of one load on the displacements of another is that of the other on its own.
// Reference of nonlinear kinds: the limit of small loads, to which they tend linearly.
TEST_P(Conformance, WorksOfTwoLoadsAreReciprocal) {
  const Model model = Make();
  const Presses& p = *GetParam().presses;
  const double small = GetParam().is_linear ? 1 : 1e-2;
  const Vector3d force = small * ForceOf(*model, Move());
  const auto load = Contact::Kind::kForce;
  const auto first = Answer(*model, {At(p.p_O, load, force), At(p.other_p_O, load, {0, 0, 0})});
  const auto second = Answer(*model, {At(p.p_O, load, {0, 0, 0}), At(p.other_p_O, load, force)});
  const double work = first[1].displacement_O.dot(force);
  const double own = first[0].displacement_O.dot(force);
  EXPECT_NE(second[0].validity, Validity::kFailed) << model->failure();
  EXPECT_NEAR(second[0].displacement_O.dot(force), work,
              ((GetParam().is_linear ? 10 * tolerance() : 1e-3) + GetParam().asymmetry) * own);
}

class LinearConformance : public Conformance {};

TEST_P(LinearConformance, ForcesSuperpose) {
  const Model model = Make();
  const auto one = Answer(*model, {Move(), MoveOther(0)});
  const auto two = Answer(*model, {Move(0), MoveOther(-2)});
  const auto both = Answer(*model, {Move(), MoveOther(-2)});
  for (std::size_t i = 0; i < 2; ++i) {
    ExpectNear(both[i].force_O, one[i].force_O + two[i].force_O,
               10 * tolerance() * one[0].force_O.norm());
  }
}

// A contact by a displacement, or by the load that causes it.
TEST_P(LinearConformance, ADisplacementBeyondTheRangeIsExtrapolated) {
  const Model model = Make();
  for (const double share : {0.9, 1.1}) {
    Contact contact = Move();
    contact.prescribed_O *= share * model->info().range * kSize / contact.prescribed_O.norm();
    const ContactResponse moved = Answer(*model, {contact}).front();
    contact.kind = Contact::Kind::kForce;
    contact.prescribed_O = moved.force_O;
    for (const ContactResponse& response : {moved, Answer(*model, {contact}).front()}) {
      EXPECT_EQ(response.validity, share < 1 ? Validity::kValid : Validity::kExtrapolated);
    }
  }
}

// Forces scale with modulus and square of the length.
TEST_P(Conformance, SizeAndModulusAreUnits) {
  const Model usual = Make();
  const Vector3d expected = ForceOf(*usual, Move()) / (kModulus * kSize * kSize);
  for (const auto& [size, modulus] :
       {std::pair{1e-9, 1.0}, {1e-9, 1e12}, {1e3, 1.0}, {1e3, 1e12}, {1.0, 1e6}}) {
    const Model model = Make(size, modulus);
    const ContactResponse response = Answer(*model, {Move(1, size)}).front();
    EXPECT_EQ(response.validity, Validity::kValid) << size << " m, " << modulus << " Pa";
    ExpectNear(response.force_O / (modulus * size * size), expected,
               10 * tolerance() * expected.norm());
  }
}

TEST_P(Conformance, OrderAndRepetitionDoNotMatter) {
  const Model model = Make();
  const auto once = Answer(*model, {Move(), MoveOther()});
  const auto again = Answer(*model, {Move(), MoveOther()});
  const auto exchanged = Answer(*model, {MoveOther(), Move()});
  const Model fresh = Make();
  const auto expected = Answer(*fresh, {MoveOther(), Move()});
  for (std::size_t i = 0; i < 2; ++i) {
    const double limit = 10 * tolerance() * once[i].force_O.norm();
    ExpectNear(again[i].force_O, once[i].force_O, limit);
    ExpectNear(exchanged[1 - i].force_O, once[i].force_O, limit);
    ExpectNear(exchanged[i].force_O, expected[i].force_O, limit);
  }
}

// The answer is finite and flagged, or a failure, and the next answer is not affected.
TEST_P(Conformance, AbsurdContactsAreFlaggedAndForgotten) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Model model = Make();
  const Vector3d expected = ForceOf(*model, Move());
  std::vector<Contact> absurd;
  for (const double bad : {kNan, kInfinite, -kInfinite, 1e300}) {
    for (const auto kind : {Contact::Kind::kDisplacement, Contact::Kind::kForce}) {
      Contact contact = Move();
      contact.kind = kind;
      absurd.push_back(contact), absurd.back().prescribed_O.x() = bad;
      absurd.push_back(contact), absurd.back().prescribed_O.y() = bad;
      absurd.push_back(contact), absurd.back().p_O.x() = bad;
      absurd.push_back(contact), absurd.back().width = bad;
    }
  }
  absurd.push_back(Move()), absurd.back().width = -0.01;
  absurd.push_back(Move()), absurd.back().element = 1 << 30;
  absurd.push_back(Move()), absurd.back().element = -7;
  for (const Contact& contact : absurd) {
    // A kind that does not use the element or the width accepts any value.
    const bool is_value = !contact.prescribed_O.allFinite() || contact.prescribed_O.norm() > 1e9;
    const ContactResponse response = Answer(*model, {contact}).front();
    EXPECT_TRUE(response.force_O.allFinite() && response.displacement_O.allFinite());
    if (is_value) EXPECT_NE(response.validity, Validity::kValid);
    const ContactResponse next = Answer(*model, {Move()}).front();
    EXPECT_EQ(next.validity, Validity::kValid) << model->failure();
    ExpectNear(next.force_O, expected, 10 * tolerance() * expected.norm());
  }
}

TEST_P(Conformance, ImpossibleContactsFailWithAReason) {
  const Model model = Make();
  Contact fixed = Move();
  fixed.p_O = kSize * GetParam().presses->fixed_O;
  for (const auto& contacts :
       {std::vector{Move(), Move()}, std::vector{Move(), Move(2)}, std::vector{fixed}}) {
    for (const ContactResponse& response : Answer(*model, contacts)) {
      EXPECT_EQ(response.validity, Validity::kFailed);
      EXPECT_TRUE(response.force_O.isZero(0));
    }
    EXPECT_NE(model->failure(), "");
  }
  const ContactResponse next = Answer(*model, {Move()}).front();
  EXPECT_EQ(next.validity, Validity::kValid);
  EXPECT_EQ(model->failure(), "");
}

TEST_P(Conformance, AModulusThatIsNoneIsRefused) {
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(const Model refused = Make(kSize, bad), std::invalid_argument) << bad;
  }
}

TEST_P(Conformance, AStiffnessIsGivenWhereItIsWanted) {
  const Model model = Make();
  const ContactResponse wanted = Answer(*model, {Move(), MoveOther()}).front();
  std::vector<Contact> unwanted{Move(), MoveOther()};
  for (Contact& contact : unwanted) contact.wants_stiffness = false;
  const ContactResponse without = Answer(*Make(), unwanted).front();
  ExpectNear(without.force_O, wanted.force_O, 10 * tolerance() * wanted.force_O.norm());
  const ContactResponse again = Answer(*model, {Move(), MoveOther()}).front();
  EXPECT_LE((again.stiffness_O - wanted.stiffness_O).norm(),
            10 * tolerance() * wanted.stiffness_O.norm());
}

TEST_P(Conformance, ASolutionKeepsItsFieldWhateverIsAskedNext) {
  const Model model = Make();
  Solution solution, other;
  model->Solve(std::vector{Move()}, &solution);
  std::vector<Vector3d> before, after;
  model->Displacements(solution, &before);
  model->Solve(std::vector{MoveOther(), Move(0)}, &other);
  model->Displacements(other, &after);
  model->Displacements(solution, &after);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    ExpectNear(after[i], before[i], 10 * tolerance() * GetParam().presses->depth * kSize);
  }
  model->Displacements({}, &after);
  EXPECT_EQ(after, std::vector<Vector3d>(before.size(), Vector3d(0, 0, 0)));
}

TEST_P(Conformance, RepeatedAnswersAllocateNothing) {
  const Model model = Make();
  std::vector<Contact> contacts{Move(), MoveOther()};
  std::vector<ContactResponse> responses(2);
  for (int k = 0; k < 3; ++k) {
    contacts[0].prescribed_O *= 1.01;
    model->Respond(contacts, responses);
  }
  const long before = AllocationCount();
  for (int k = 0; k < 5; ++k) {
    contacts[0].prescribed_O *= 1.01;
    model->Respond(contacts, responses);
  }
  EXPECT_EQ(AllocationCount(), before);
}

// Law: without friction there is no tangential traction, so that an oblique displacement has the
// same effect as its component along the normal. Tested for a node, the midpoint of an element's
// edge and a disc.
class FrictionlessConformance : public Conformance {};

TEST_P(FrictionlessConformance, ContactsPushAlongTheNormalOnly) {
  const Model model = Make();
  const bool is_plane = GetParam().presses == &kOnBlock;
  const Vector3d normal = is_plane ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d &one = GetParam().presses->p_O, &other = GetParam().presses->other_p_O;
  for (const Vector3d& place : {one, other, Vector3d((one + other) / 2)}) {
    for (const double width : {0.0, 0.4}) {
      const auto press = [&](double across) {
        Contact contact =
            At(place, Contact::Kind::kDisplacement, kSize * across * Vector3d::UnitX());
        contact.prescribed_O -= 0.002 * kSize * normal;
        contact.width = width * kSize;
        return Answer(*model, {contact}).front();
      };
      const ContactResponse straight = press(0), slanted = press(0.006);
      ASSERT_NE(slanted.validity, Validity::kFailed) << model->failure();
      const double size = straight.force_O.norm();
      EXPECT_LT(straight.force_O.dot(normal), -0.999 * size);
      ExpectNear(slanted.force_O, straight.force_O, tolerance() * size);
      EXPECT_NEAR(slanted.displacement_O.x(), 0.006 * kSize, 1e-15) << "as prescribed";
    }
  }
}

std::string NameOfCase(const testing::TestParamInfo<TestedKind>& tested) {
  std::string name = tested.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
}
std::vector<TestedKind> LinearKinds() {
  std::vector<TestedKind> kinds = TestedKinds();
  std::erase_if(kinds, [](const TestedKind& kind) { return !kind.is_linear; });
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Conformance, testing::ValuesIn(TestedKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, LinearConformance, testing::ValuesIn(LinearKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, FrictionlessConformance, testing::ValuesIn(FrictionlessKinds()),
                         NameOfCase);

}  // namespace
}  // namespace palpate

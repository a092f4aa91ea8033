// Tests the requirements of deformation_model.h with every kind of model. A new kind is added by
// one line in TestedKinds().
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/extruded/extruded_model.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"
#include "slave/mechanics/relaxation/relaxing_model.h"
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
// Of tools that cover 13 nodes of a cube of twelve cells.
const Presses kByTools{{0.25, 0.5, 1}, {0.75, 0.5, 1}, {0.5, 0.5, 0}, {0.1, 0.05, -1}};
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
  bool acts_alone = false;  // one contact at a time
  // The answer depends on earlier ones. It is tested from rest, in time after one step.
  bool has_history = false;
  double width = 0;     // of rigid tools that touch and leave; 0: contacts that move one place
  double friction = 0;  // Coulomb's coefficient of such tools
};
void PrintTo(const TestedKind& kind, std::ostream* out) {
  *out << kind.name;
}

struct CubeBody {
  SolidMesh mesh;
  HeldNodes held;  // supports: the bottom
};
CubeBody MakeCube(double size, int across = 4) {
  const SolidMesh mesh = MeshBox({size, size, size}, {across, across, 4});
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

TestedKind ByTool(const char* name, Law law, double friction) {
  const ContactLaw contact = friction > 0 ? ContactLaw::kFriction : ContactLaw::kFrictionless;
  return {.name = name,
          .presses = &kByTools,
          .is_linear = false,
          .tolerance = 1e-6,
          .make = [=](double size, double modulus) -> Model {
            FemModel::Params params{
                .material = {.young_modulus = modulus, .poisson_ratio = 0.3, .density = 0},
                .options = {.law = law, .residual = 1e-10},
                .range = 0.1,
                .contact = contact,
                .friction = friction};
            const CubeBody cube = MakeCube(size, 12);
            return std::make_unique<FemModel>(cube.mesh, cube.held, params);
          },
          .has_history = true,
          .width = 0.35,
          .friction = friction};
}

TestedKind Solid(const char* name, Element element, Law law, double nu = 0.3) {
  return {name, &kOnCube, law == Law::kLinear, 1e-7, [=](double size, double modulus) -> Model {
            std::vector<OgdenTerm> terms;
            if (law == Law::kOgden) terms = {{0.7, 3}, {0.3, -2}};
            SolidModel::Params params{
                .options = {.element = element, .law = law, .terms = terms, .residual = 1e-10},
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

TestedKind Extruded() {
  return {.name = "extruded",
          .presses = &kOnBlock,
          .is_linear = true,
          .tolerance = 1e-9,
          .make = [](double size, double modulus) -> Model {
            const ReferenceProblem problem = bodies::Block(60, size, 0.4);
            const double thickness = 0.1 * size;
            return std::make_unique<ExtrudedModel>(problem.mesh, problem.held,
                                                   ExtrudedModel::Params{.young_modulus = modulus,
                                                                         .poisson_ratio = 0.4,
                                                                         .thickness = thickness,
                                                                         .depth = thickness});
          },
          .acts_alone = true};
}

TestedKind Relaxing() {
  TestedKind kind = Green("fem-green-relaxing", Element::kTet4);
  kind.make = [elastic = kind.make](double size, double modulus) -> Model {
    const std::array<RelaxationTerm, 2> terms{{{0.3, 0.1}, {0.2, 5}}};
    return std::make_unique<RelaxingModel>(elastic(size, modulus), terms, 0.02);
  };
  kind.has_history = true;
  return kind;
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
      Solid("fem-tet4-ogden", Element::kTet4, Law::kOgden),
      Solid("fem-tet10-ogden", Element::kTet10, Law::kOgden),
      ByTool("fem-linear-friction", Law::kLinear, 0.3),
      ByTool("fem-corotational-friction", Law::kCorotational, 0.3),
      ByTool("fem-neo-hookean-friction", Law::kNeoHookean, 0.3),
      ByTool("fem-neo-hookean-frictionless", Law::kNeoHookean, 0),
      Extruded(),
      Relaxing(),
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
  // Returns a displacement at `place`, `factor` times the usual depth.
  [[nodiscard]] static Contact MoveAt(const Vector3d& place, double factor, double size) {
    const TestedKind& kind = GetParam();
    const Vector3d moved = factor * kind.presses->depth * size * kind.presses->direction;
    Contact contact = At(place, Contact::Kind::kDisplacement, moved, size);
    contact.width = kind.width * size;
    return contact;
  }
  [[nodiscard]] static Contact Move(double factor = 1, double size = kSize) {
    return MoveAt(GetParam().presses->p_O, factor, size);
  }
  [[nodiscard]] static Contact MoveOther(double factor = 1) {
    return MoveAt(GetParam().presses->other_p_O, factor, kSize);
  }
  // Returns contacts at both places, or at the first one only if the kind takes one at a time.
  [[nodiscard]] static std::vector<Contact> MoveBoth() {
    std::vector<Contact> contacts{Move(), MoveOther()};
    if (GetParam().acts_alone) contacts.pop_back();
    return contacts;
  }
  static std::vector<ContactResponse> Answer(DeformationModel& model,
                                             const std::vector<Contact>& contacts) {
    if (GetParam().has_history) model.Reset();
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

// Contacts that move their place, whatever its force.
class HeldConformance : public Conformance {};

TEST_P(HeldConformance, ALoadInvertsADisplacement) {
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
  const ContactResponse response = Answer(*model, MoveBoth()).front();
  if (response.stiffness_O.isZero(0)) return;  // this kind gives no stiffness
  for (const double side : {0.0, 1.0}) {  // along the press, and tangentially if this has a force
    Vector3d step = 1e-3 * Move().prescribed_O;
    if (side > 0) step = Vector3d(step.z(), 0, -step.x());
    if (side > 0 && response.force_O.head<2>().isZero(0)) continue;
    std::vector<Contact> more = MoveBoth(), less = MoveBoth();
    more[0].prescribed_O += step, less[0].prescribed_O -= step;
    const Vector3d change =
        Answer(*model, more).front().force_O - Answer(*model, less).front().force_O;
    const Vector3d expected = 2 * (response.stiffness_O * step);
    ExpectNear(change, expected, 1e-3 * expected.norm() + 1e-9 * response.force_O.norm());
  }
}

// Kinds of several contacts.
class PairConformance : public Conformance {};

// Betti: the work of one load on the displacements of another is that of the other on its own.
// Reference of nonlinear kinds: the limit of small loads, to which they tend linearly.
TEST_P(PairConformance, WorksOfTwoLoadsAreReciprocal) {
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
  std::vector<Contact> contacts = MoveBoth();
  // The second contact, or a second motion of the only one.
  const auto ask = [&](double first, double second) {
    contacts = MoveBoth();
    Vector3d& moved = contacts[0].prescribed_O;
    const double across = moved.head<2>().isZero(0) ? 0 : 0.3 * moved.norm();
    const Vector3d aside(0, across, 0);
    moved = first * moved + second * (0.5 * moved + aside);
    if (contacts.size() > 1) contacts[1].prescribed_O *= -2 * second;
    return Answer(*model, contacts);
  };
  const auto one = ask(1, 0), two = ask(0, 1), both = ask(1, 1);
  for (std::size_t i = 0; i < both.size(); ++i) {
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
  std::vector<Contact> contacts = MoveBoth();
  const auto once = Answer(*model, contacts);
  const auto again = Answer(*model, contacts);
  std::ranges::reverse(contacts);
  const auto exchanged = Answer(*model, contacts);
  const Model fresh = Make();
  const auto expected = Answer(*fresh, contacts);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const double limit = 10 * tolerance() * once[i].force_O.norm();
    ExpectNear(again[i].force_O, once[i].force_O, limit);
    ExpectNear(exchanged[contacts.size() - 1 - i].force_O, once[i].force_O, limit);
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
  const ContactResponse wanted = Answer(*model, MoveBoth()).front();
  std::vector<Contact> unwanted = MoveBoth();
  for (Contact& contact : unwanted) contact.wants_stiffness = false;
  const ContactResponse without = Answer(*Make(), unwanted).front();
  ExpectNear(without.force_O, wanted.force_O, 10 * tolerance() * wanted.force_O.norm());
  const ContactResponse again = Answer(*model, MoveBoth()).front();
  EXPECT_LE((again.stiffness_O - wanted.stiffness_O).norm(),
            10 * tolerance() * wanted.stiffness_O.norm());
}

TEST_P(Conformance, ASolutionKeepsItsFieldWhateverIsAskedNext) {
  const Model model = Make();
  Solution solution, other;
  model->Solve(std::vector{Move()}, &solution);
  std::vector<Vector3d> before, after;
  model->Displacements(solution, &before);
  std::vector<Contact> next{MoveOther()};
  if (!GetParam().acts_alone) next.push_back(Move(0));
  model->Solve(next, &other);
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
  std::vector<Contact> contacts = MoveBoth();
  std::vector<ContactResponse> responses(contacts.size());
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

// Law: Coulomb's. The press goes down, along the surface with several increments, and up.
class ToolConformance : public Conformance {};

TEST_P(ToolConformance, ForcesAreInCoulombsConeAndEndWithTheContact) {
  const Model model = Make();
  const double depth = 10 * kSize * GetParam().presses->depth;
  const auto answer = [&](double along, double down) {
    Contact contact = Move();
    contact.prescribed_O = {along, 0, -down};
    ContactResponse response;
    model->Respond({&contact, 1}, {&response, 1});
    EXPECT_NE(response.validity, Validity::kFailed) << model->failure();
    return response.force_O;
  };
  const double mu = GetParam().friction;
  const double scale = answer(0, depth).norm();
  for (const double along : {1.0, 2.0, 0.0}) {
    const Vector3d force = answer(along * depth, depth);
    EXPECT_LT(force.z(), -0.5 * scale);
    EXPECT_LE(force.head<2>().norm(), (mu + 1e-6) * -force.z());
    // Reference: it slides at a way of a depth, with full friction against the motion.
    const double forward = along > 0 ? 1 : -1;
    EXPECT_NEAR(force.x(), forward * mu * -force.z(), 0.05 * mu * -force.z() + 1e-6 * scale);
  }
  EXPECT_LE(answer(0, -depth).norm(), 1e-9 * scale);
}

std::string NameOfCase(const testing::TestParamInfo<TestedKind>& tested) {
  std::string name = tested.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
}
std::vector<TestedKind> KindsThat(const auto& pass) {
  std::vector<TestedKind> kinds;
  std::ranges::copy_if(TestedKinds(), std::back_inserter(kinds), pass);
  return kinds;
}
std::vector<TestedKind> LinearKinds() {
  return KindsThat([](const TestedKind& kind) { return kind.is_linear; });
}
std::vector<TestedKind> ToolKinds() {
  return KindsThat([](const TestedKind& kind) { return kind.width > 0; });
}
std::vector<TestedKind> HeldKinds() {
  return KindsThat([](const TestedKind& kind) { return kind.width == 0; });
}
std::vector<TestedKind> PairKinds() {
  return KindsThat([](const TestedKind& kind) { return !kind.acts_alone; });
}

INSTANTIATE_TEST_SUITE_P(Kinds, Conformance, testing::ValuesIn(TestedKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, HeldConformance, testing::ValuesIn(HeldKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, PairConformance, testing::ValuesIn(PairKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, ToolConformance, testing::ValuesIn(ToolKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, LinearConformance, testing::ValuesIn(LinearKinds()), NameOfCase);
INSTANTIATE_TEST_SUITE_P(Kinds, FrictionlessConformance, testing::ValuesIn(FrictionlessKinds()),
                         NameOfCase);

}  // namespace
}  // namespace palpate

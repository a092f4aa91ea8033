// Patches and bending that a mesh is too coarse for are extrapolated, in every model of volumes.
#include "slave/mechanics/mesh_resolution.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/footprint/disc_compliance.h"
#include "tests/slave/mechanics/contacts.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

struct ElementKind {
  std::string name, kind;
  std::function<void(FemOptions*)> set = [](FemOptions*) {};
};

const std::vector<ElementKind>& ElementKinds() {
  static const std::vector<ElementKind> kinds{
      {"fem", "fem"},
      {"fem tet10", "fem", [](FemOptions* o) { o->element = FemOptions::Element::kTet10; }},
      {"fem neo-hookean", "fem", [](FemOptions* o) { o->law = FemOptions::Law::kNeoHookean; }},
      {"fem-green", "fem-green"},
      {"fem-green tet10", "fem-green",
       [](FemOptions* o) { o->element = FemOptions::Element::kTet10; }}};
  return kinds;
}

struct Box {
  Vector3d size{1, 1, 1};
  std::array<int, 3> cells{1, 1, 1};
  int held = 2;  // axis of the fixed side
  double nu = 0.3;
};

std::unique_ptr<DeformationModel> MakeBox(const ElementKind& kind, const Box& box) {
  Scene scene;
  scene.object.geometry = BoxGeometry{box.size, box.cells};
  scene.object.material = {.young_modulus = 1, .poisson_ratio = box.nu, .density = 1};
  scene.object.fixed = {Fixed{FixedPlane{box.held, 0}, {true, true, true}}};
  scene.model.kind = kind.kind;
  scene.model.range = 1;
  kind.set(&scene.model.fem);
  return MakeModel(scene, MeshObject(scene, std::nullopt));
}

Contact PressOf(bool loaded, const Vector3d& p_O, double width) {
  const Vector3d down(0, 0, -1e-6);
  return loaded ? contacts::Push(p_O, std::max(width, 0.01) * down, width)
                : contacts::Move(p_O, down, width);
}

double StiffnessOf(const ContactResponse& r) {
  return r.force_O.z() / r.displacement_O.z();
}

// Stiffness of a disc bonded to a half-space (Spence 1968), or of a disc with uniform pressure by
// the mean displacement (Johnson, Contact Mechanics, 3.4). E = 1.
double HalfSpace(bool loaded, double width, double nu) {
  const double a = width / 2, G = 1 / (2 * (1 + nu));
  if (loaded) return 3 * std::pow(std::numbers::pi, 2) * a / (16 * (1 - nu * nu));
  return 4 * G * a * std::log(3 - 4 * nu) / (1 - 2 * nu);
}

// Places at nodes, at the centre of a cell and of a triangle, and between them.
std::vector<Vector3d> PlacesOnTop(int n) {
  const double h = 1.0 / n, c = std::floor(0.5 * n) * h;
  return {{c, c, 1},
          {c + h / 2, c + h / 2, 1},
          {c + h / 3, c + 2 * h / 3, 1},
          {c + 0.1 * h, c + 0.25 * h, 1},
          {c + 0.8 * h, c + 0.45 * h, 1}};
}

int CellsOf(const ElementKind& kind) {
  return kind.name == "fem tet10" ? 4 : 6;
}

bool KnowsNarrowDiscs(const ElementKind& kind, bool loaded) {
  return kind.name == "fem-green tet10" || (kind.kind == "fem-green" && !loaded);
}

// A tool of 1 and 2 mm on the foam cube of 60 mm with cells of 10 mm: at this mesh density the
// answer is 2 to 21 times too stiff.
TEST(PatchResolution, ATouchThatIsNarrowerThanTheMeshIsExtrapolated) {
  for (const ElementKind& kind : ElementKinds()) {
    const int n = CellsOf(kind);
    const auto model = MakeBox(kind, {.cells = {n, n, n}, .nu = 0.15});
    for (const double width : {1.0 / 60, 2.0 / 60}) {
      for (const Vector3d& p_O : PlacesOnTop(n)) {
        for (const bool loaded : {false, true}) {
          if (KnowsNarrowDiscs(kind, loaded)) continue;
          const ContactResponse r = contacts::Query(*model, PressOf(loaded, p_O, width));
          EXPECT_EQ(r.validity, Validity::kExtrapolated) << kind.name << " at " << p_O.transpose();
          EXPECT_EQ(r.flag_reason, kCoarsePatch) << kind.name;
        }
      }
    }
  }
}

// Reference: the half-space, since the disc is some thirty times narrower than the cube. The error
// is within 5 % (measured: 3 %); the mesh alone was up to 21 times too stiff.
TEST(PatchResolution, ANarrowDiscIsAsStiffAsOnAHalfSpace) {
  for (const ElementKind& kind : ElementKinds()) {
    const int n = 6;
    for (const double nu : {0.15, 0.45}) {
      const auto model = MakeBox(kind, {.cells = {n, n, n}, .nu = nu});
      for (const double width : {1e-4, 1.0 / 60, 2.0 / 60}) {
        for (const Vector3d& p_O : PlacesOnTop(n)) {
          for (const bool loaded : {false, true}) {
            if (!KnowsNarrowDiscs(kind, loaded)) continue;
            const ContactResponse r = contacts::Query(*model, PressOf(loaded, p_O, width));
            const std::string where =
                Formatted("%s, nu %.2f, width %.4f, x %.3f", kind.name.c_str(), nu, width, p_O.x());
            EXPECT_NE(r.flag_reason, kCoarsePatch) << where;
            EXPECT_NEAR(StiffnessOf(r) / HalfSpace(loaded, width, nu), 1, 0.05) << where;
            EXPECT_NEAR(r.stiffness_O(2, 2) / StiffnessOf(r), 1, loaded ? 0.02 : 1e-9) << where;
          }
        }
      }
    }
  }
}

// A disc of 2.96 to 3.6 cells has 27 to 47 nodes. Reference: a flat bonded disc on the same body,
// from the half-space's compliance and quadratic bricks (tests/campaigns/truth/pressed_box.py).
// The estimate of the nodes' stiffness is within 4 % (measured); without it the nodes are 4 to 10 %
// too compliant.
TEST(PatchResolution, ADiscOfManyNodesIsAsStiffAsTheTool) {
  struct Case {
    double nu, width, x, stiffness;
  };
  for (const Case& c : {Case{0.3, 0.37, 0.5, 0.4707},
                        {0.3, 0.42, 0.53, 0.5400},
                        {0.3, 0.45, 0.5625, 0.5796},
                        {0.49, 0.37, 0.5, 0.5378},
                        {0.49, 0.42, 0.53, 0.6158},
                        {0.49, 0.45, 0.5625, 0.6599}}) {
    const auto model =
        MakeBox(ElementKinds().back(), {.size = {1, 1, 0.8}, .cells = {8, 8, 6}, .nu = c.nu});
    const ContactResponse r = contacts::Query(*model, PressOf(false, {c.x, 0.5, 0.8}, c.width));
    EXPECT_EQ(r.validity, Validity::kValid);
    EXPECT_NEAR(StiffnessOf(r) / c.stiffness, 1, 0.04) << c.width << " at " << c.x << ", " << c.nu;
  }
}

// A disc of an eighth of a cube's side on cells of a sixth. References: pressed_box.py of the
// campaigns, bonded, nu 0.3.
TEST(PatchResolution, ANarrowDiscOnACoarseMeshIsWithinItsStatedError) {
  for (const ElementKind& kind : ElementKinds()) {
    if (!KnowsNarrowDiscs(kind, false)) continue;
    const auto coarse = MakeBox(kind, {.cells = {6, 6, 6}});
    for (const auto& [p_O, stiffness] : {std::pair(Vector3d(0.5, 0.5, 1), 0.14295),
                                         std::pair(Vector3d(0.7083, 0.6667, 1), 0.13606)}) {
      const ContactResponse is = contacts::Query(*coarse, PressOf(false, p_O, 1.0 / 8));
      const double stated = is.force_error / is.force_O.norm();
      EXPECT_LT(std::abs(StiffnessOf(is) / stiffness - 1), 1.5 * stated) << kind.name;
      EXPECT_LT(stated, 0.15) << kind.name;
    }
  }
}

// Where the body is not like a half-space at the scale of the mesh, the answer of the mesh is
// flagged as before.
TEST(PatchResolution, ANarrowDiscByAnEdgeOnAThinPartOrBesideAnotherIsExtrapolated) {
  const double width = 1.0 / 60;
  for (const ElementKind& kind : ElementKinds()) {
    if (!KnowsNarrowDiscs(kind, false)) continue;
    const auto cube = MakeBox(kind, {.cells = {6, 6, 6}});
    const auto pad = MakeBox(kind, {.size = {1, 1, 0.1}, .cells = {6, 6, 1}});
    EXPECT_EQ(contacts::Query(*cube, PressOf(false, {0.97, 0.5, 1}, width)).flag_reason,
              kCoarsePatch)
        << "by an edge";
    EXPECT_EQ(contacts::Query(*cube, PressOf(false, {0.0, 0.5, 0.1}, width)).flag_reason,
              kCoarsePatch)
        << "by what is held";
    EXPECT_EQ(contacts::Query(*pad, PressOf(false, {0.52, 0.51, 0.1}, width)).flag_reason,
              kCoarsePatch)
        << "a thin pad";
    const std::array beside{PressOf(false, {0.4, 0.5, 1}, width),
                            PressOf(false, {0.6, 0.5, 1}, width)};
    std::array<ContactResponse, 2> both;
    cube->Respond(beside, both);
    EXPECT_EQ(both[0].flag_reason, kCoarsePatch) << kind.name;
    EXPECT_EQ(both[1].flag_reason, kCoarsePatch) << kind.name;
    // After the other contact has ended, the answer is the same as if that contact had never
    // existed.
    const double alone =
        contacts::Query(*MakeBox(kind, {.cells = {6, 6, 6}}), beside[0]).force_O.z();
    const ContactResponse again = contacts::Query(*cube, beside[0]);
    EXPECT_EQ(again.flag_reason, "") << kind.name;
    EXPECT_NEAR(again.force_O.z() / alone, 1, 1e-12) << kind.name;
  }
}

// Law: an answer that is updated from the previous one equals that of a new model.
TEST(PatchResolution, ANarrowDiscThatMovesAmongManyContactsIsAnsweredAsAlone) {
  for (const ElementKind& kind : ElementKinds()) {
    if (!KnowsNarrowDiscs(kind, false)) continue;
    const Box box{.cells = {6, 6, 6}};
    std::vector<Contact> contacts{PressOf(false, {0.5, 0.5, 1}, 1.0 / 60)};
    for (int i = 0; i < 6; ++i) {
      for (int j = 1; j < 5; ++j) {
        for (const double x : {0.0, 1.0})
          contacts.push_back(PressOf(false, {x, i / 6.0, j / 6.0}, 0));
      }
    }
    const auto moves = MakeBox(kind, box), is_new = MakeBox(kind, box);
    std::vector<ContactResponse> got(contacts.size()), wanted(contacts.size());
    for (const double x : {0.5, 0.45, 0.55, 0.52}) {
      contacts[0].p_O.x() = x;
      moves->Respond(contacts, got);
      is_new->Respond({}, {});
      is_new->Respond(contacts, wanted);
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        ASSERT_EQ(got[i].flag_reason, "");
        EXPECT_LT((got[i].force_O - wanted[i].force_O).norm(), 1e-9 * wanted[0].force_O.norm())
            << kind.name << " " << i;
        EXPECT_LT((got[i].stiffness_O - wanted[i].stiffness_O).norm(),
                  1e-9 * wanted[i].stiffness_O.norm());
      }
    }
  }
}

// Reference: the half-space. For a cube with a supported bottom it is accurate to 3 % up to a third
// of a side (the effects of the fixed bottom and the free sides nearly cancel: measured with 24
// cells). A valid answer is within 10 % plus the estimate's own 8 %; an answer with an error above
// a quarter is never valid; of the answers of `fem-green` within 5 %, two thirds are valid. `fem`
// flags all contacts with so few nodes of ten-node tetrahedra (see
// FewNodesUnderAToolAreRightOrExtrapolated).
TEST(PatchResolution, IsJudgedAsTheHalfSpaceDoes) {
  for (const ElementKind& kind : ElementKinds()) {
    const bool is_slow = kind.name.ends_with("tet10");
    if (!is_slow && kind.kind != "fem-green") continue;  // as fem-green
    const int n = is_slow ? 6 : 12;
    const Box box{.cells = {n, n, n}};
    const auto model = MakeBox(kind, box);
    int good = 0, valid = 0;
    for (const double edges : {0.3, 0.5, 0.7, 1.0, 1.3, 1.6, 2.0, 2.3, 2.6, 3.0, 3.5, 4.0}) {
      const double width = edges / n;
      if (width > 0.45 || (is_slow && edges != 1.6 && edges != 2 && edges != 2.3)) continue;
      for (const Vector3d& p_O : PlacesOnTop(n)) {
        for (const bool loaded : {false, true}) {
          const ContactResponse r = contacts::Query(*model, PressOf(loaded, p_O, width));
          const double off = std::abs(StiffnessOf(r) / HalfSpace(loaded, width, box.nu) - 1);
          const bool is_valid = r.validity == Validity::kValid;
          EXPECT_LT(is_valid ? off : 0, 0.18) << kind.name << (loaded ? " loaded" : " moved")
                                              << ", " << edges << " edges at " << p_O.transpose();
          if (kind.kind == "fem") continue;
          good += off < 0.05 ? 1 : 0;
          valid += off < 0.05 && is_valid ? 1 : 0;
        }
      }
    }
    EXPECT_GE(3 * valid, 2 * good) << kind.name << ": of " << good;
  }
}

// Laws: a body that keeps its volume does not hold a disc by sticking (Spence), nor by Poisson's
// ratio (Mindlin); a bonded disc is stiffer; under a uniform load the centre has the larger
// displacement.
TEST(DiscCompliance, SticksSlidesAndSinksAsItMust) {
  EXPECT_NEAR(OfBondedDisc(0.5).normal, OfSlidingDisc(0.5).normal, 1e-12);
  EXPECT_NEAR(OfBondedDisc(0.5).across, (2 - 0.5) * 1.5 / 4, 1e-12);
  EXPECT_NEAR(OfBondedDisc(0.5 - 1e-7).normal, OfBondedDisc(0.5).normal, 1e-6);
  for (const double nu : {-0.5, 0.0, 0.2, 0.4}) {
    EXPECT_LT(OfBondedDisc(nu).normal, OfSlidingDisc(nu).normal) << nu;
    EXPECT_GT(OfEvenLoad(nu).normal, OfSlidingDisc(nu).normal) << nu;
    EXPECT_NEAR(OfEvenLoad(nu).across / OfEvenLoad(nu).normal, (2 - nu) / (2 * (1 - nu)), 1e-12)
        << nu;
  }
  const Eigen::Matrix3d around = OfEvenLoad(0.3).Around({0, 0.6, 0.8});
  EXPECT_NEAR(Vector3d(0, 0.6, 0.8).dot(around * Vector3d(0, 0.6, 0.8)), OfEvenLoad(0.3).normal,
              1e-12);
  EXPECT_NEAR((around * Vector3d::UnitX()).norm(), OfEvenLoad(0.3).across, 1e-12);
}

// Reference: E A / L. The tool covers the end except its corners, whose nodes it does not move. The
// loaded area is a third smaller, but this has no effect one thickness away from the end.
TEST(PatchResolution, TheEndOfABarIsNoNarrowPatch) {
  for (const ElementKind& kind : ElementKinds()) {
    for (const double length : {4.0, 20.0}) {
      const Box box{
          .size = {length, 1, 1.3}, .cells = {6 * static_cast<int>(length), 3, 4}, .held = 0};
      const auto model = MakeBox(kind, box);
      const ContactResponse r =
          contacts::Query(*model, contacts::Move({length, 0.5, 0.65}, {-1e-6, 0, 0}, 1.3));
      EXPECT_EQ(r.flag_reason, "") << kind.name << " " << length;
      EXPECT_NEAR(-r.force_O.x() / (1e-6 * 1.3 / length), 1, 0.05) << kind.name << " " << length;
    }
  }
}

// Reference: the half-space, within 3 % (see IsJudgedAsTheHalfSpaceDoes). A valid answer under a
// tool of 1.3 to 3 elements is within 10 % plus these 3 %. Nine to 25 nodes of ten-node tetrahedra,
// whose area is right, are up to 23 % off.
TEST(PatchResolution, FewNodesUnderAToolAreRightOrExtrapolated) {
  int valid = 0, flagged = 0;
  for (const int n : {6, 8}) {
    const Box box{.cells = {n, n, n}};
    const auto model = MakeBox(ElementKinds()[1], box);
    for (const double elements : {1.3, 1.7, 2.0, 2.5, 3.0}) {
      for (const Vector3d& p_O : PlacesOnTop(n)) {
        const ContactResponse r = contacts::Query(*model, PressOf(false, p_O, elements / n));
        const double off = std::abs(StiffnessOf(r) / HalfSpace(false, elements / n, box.nu) - 1);
        const bool is_valid = r.validity == Validity::kValid;
        EXPECT_LT(is_valid ? off : 0, 0.13) << n << " " << elements << " " << p_O.transpose();
        (is_valid ? valid : flagged) += 1;
      }
    }
  }
  EXPECT_GT(valid, 8);
  EXPECT_GT(flagged, 8);
}

// Reference: Timoshenko's beam, with a unit square as cross section, under a uniform load on its
// end, with the compliance L^3 / 3 E I + L / (5/6 G A), and the bar with the compliance L / E A.
// The support prevents lateral contraction: stiffer by 0.8 nu^2 / L in bending and 0.3 nu^2 / L
// pressed, which are the limits of boundary elements on 5:1 with 4 and 6 triangles across (nu 0.3:
// 1.4 and 0.5 %; nu 0.45: 3.3 and 1.3 %). A valid answer is within 5 %; an answer within 1 % is
// valid.
TEST(StrainResolution, ABeamWithTooFewElementsIsExtrapolated) {
  const std::vector<std::pair<int, int>> coarse{{1, 1},  {2, 1},  {3, 1},  {4, 1},  {5, 1}, {7, 1},
                                                {10, 1}, {15, 1}, {20, 1}, {40, 1}, {1, 2}, {2, 2},
                                                {3, 2},  {5, 2},  {10, 2}, {20, 2}, {10, 3}};
  for (const ElementKind& kind : ElementKinds()) {
    // The first two kinds are tested over all values, the others over some.
    const bool is_swept = &kind < &ElementKinds()[2];
    auto cells = coarse;
    if (kind.name == "fem-green") cells.emplace_back(40, 10);  // where four nodes do
    int valid = 0, flagged = 0, bent_and_valid = 0;
    const double most = kind.name.ends_with("tet10") ? 0.48 : 0.39;  // four nodes: below kLocks
    for (const double nu :
         is_swept ? std::vector{0.0, 0.3, 0.9 * most, most} : std::vector{0.05, most}) {
      for (const double length :
           is_swept ? std::vector{5.0, 8.0, 20.0, 100.0, 1000.0} : std::vector{5.0, 20.0, 1000.0}) {
        for (const auto& [along, across] : cells) {
          if (across > 3 && (length > 5 || nu > 0.4)) continue;
          const auto model = MakeBox(
              kind,
              {.size = {length, 1, 1}, .cells = {along, across, across}, .held = 0, .nu = nu});
          const double G = 1 / (2 * (1 + nu));
          const double bent =
              (4 * std::pow(length, 3) + length / (5.0 / 6 * G)) / (1 + 0.8 * nu * nu / length);
          const double pressed = length / (1 + 0.3 * nu * nu / length);
          for (const bool bends : {false, true}) {
            const Vector3d force =
                bends ? Vector3d(0, 0, -1e-7 / std::pow(length, 2)) : Vector3d(-1e-7, 0, 0);
            model->Reset();
            const ContactResponse r =
                contacts::Answer(*model, contacts::Push({length, 0.5, 0.5}, force, 4));
            if (r.validity == Validity::kFailed) continue;  // no equilibrium, in words
            const double k = force.dot(r.force_O) / force.dot(r.displacement_O);
            const double off = std::abs(k * (bends ? bent : pressed) - 1);
            const bool is_valid = r.validity == Validity::kValid;
            const std::string where =
                Formatted("%s %g:1, %d x %d, nu %g, %s: %.4f", kind.name.c_str(), length, along,
                          across, nu, bends ? "bent" : "pressed", off);
            EXPECT_LT(is_valid ? off : 0, 0.05) << where;
            EXPECT_TRUE(is_valid || off > 0.01) << where;
            EXPECT_TRUE(is_valid || r.flag_reason == kStiffInBending)
                << where << " " << r.flag_reason;
            (is_valid ? valid : flagged) += 1;
            bent_and_valid += is_valid && bends ? 1 : 0;
          }
        }
      }
    }
    EXPECT_GT(valid, 30) << kind.name;
    EXPECT_GT(flagged, 30) << kind.name;
    EXPECT_EQ(bent_and_valid > 0, kind.name.ends_with("tet10") || kind.name == "fem-green")
        << kind.name;
  }
}

// A block, a pad and a long bar that is fixed along its side do not bend under a finger.
TEST(StrainResolution, BodiesThatDoNotBendAreNotFlagged) {
  for (const ElementKind& kind : ElementKinds()) {
    for (const Box& box : {Box{.cells = {6, 6, 6}}, Box{.size = {4, 4, 0.5}, .cells = {16, 16, 2}},
                           Box{.size = {5, 1, 1}, .cells = {20, 4, 4}}}) {
      if (kind.name != "fem" && kind.name != "fem-green" && box.cells[0] > 6) continue;
      const auto model = MakeBox(kind, box);
      const Vector3d top(box.size.x() / 2, box.size.y() / 2, box.size.z());
      for (const double width : {0.0, 1.0}) {
        const ContactResponse r = contacts::Query(*model, PressOf(false, top, width));
        EXPECT_NE(r.flag_reason, kStiffInBending) << kind.name << " " << box.size.transpose();
      }
    }
  }
}

HeldNodes Free(const SolidMesh& mesh) {
  return HeldNodes(mesh.nodes.size());
}

// Law: ten nodes follow pure bending exactly, in any direction.
TEST(StrainResolution, PureBendingIsExactWithTenNodes) {
  const SolidMesh mesh = MeshBox({4, 1, 2}, {2, 1, 1});
  const TetMesh quadratic = MakeTetMesh(mesh, 10, 1);
  std::vector<Vector3d> u;
  for (const Vector3d& p : quadratic.nodes)
    u.emplace_back(1e-9 * Vector3d(-p.x() * p.z(), 0, p.x() * p.x() / 2));
  StrainResolution strain(quadratic, Free(mesh), 0);
  strain.Take(u);
  EXPECT_LT(strain.Softness({}), 1e-12);
  u.back().x() += 1e-9;
  strain.Take(u);
  EXPECT_GT(strain.Softness({}), 0.01);
}

// The estimate does not depend on size, and rotations of the whole body have no effect.
TEST(StrainResolution, IsTheSameAtEverySizeAndTurned) {
  double first = 0;
  for (const double size : {1.0, 1e-6, 1e3}) {
    const SolidMesh mesh = MeshBox({4 * size, size, size}, {4, 1, 1});
    StrainResolution strain(MakeTetMesh(mesh, 4, 1), Free(mesh), 0.3);
    for (const double angle : {0.0, 1.0, 2.5}) {
      const Eigen::AngleAxisd turned(angle, Vector3d(1, 2, 3).normalized());
      std::vector<Vector3d> u;
      for (const Vector3d& p : mesh.nodes) {
        const double x = p.x() / size, z = p.z() / size - 0.5;
        const Vector3d bent = p + 1e-4 * size * Vector3d(-x * z, 0, x * x / 2);
        u.push_back(turned * bent - p);
      }
      strain.Take(u);
      const double softness = strain.Softness({});
      if (first == 0) first = softness;
      EXPECT_GT(softness, 0.3);
      EXPECT_NEAR(softness / first, 1, 1e-6) << size << " " << angle;
    }
  }
}

}  // namespace
}  // namespace palpate

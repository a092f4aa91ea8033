// Bodies with closed-form solutions, and the comparison of an answer with them.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate::extremes {

// A kind of model as named in scenes, and its required accuracy.
struct Family {
  std::string name;                        // for people
  std::string kind;                        // model.kind
  std::function<void(ModelOptions*)> set;  // the other options; may be empty
  double bound = 1e-6;  // relative error of a uniform stretch that the method allows
  // The held and the pulled side are glued, so that the stretch is not uniform: u_x lies between
  // that without and that with the whole lateral contraction restrained (energy theorems).
  bool is_glued = false;

  [[nodiscard]] bool is_quadratic() const { return name.ends_with("tet10"); }
};

// Boxes under uniform tension along x, on rollers at x = 0, y = 0 and z = 0: u_x(L) = F L / (E A)
// for any Poisson ratio, exactly so for every element that passes the patch test.
const std::vector<Family>& Volumes();
// Rectangles under the same; in plane strain E is E / (1 - nu^2).
const std::vector<Family>& Outlines();
// Clamped discs pressed at their centre.
const std::vector<Family>& Membranes();

struct Stretch {
  double length = 0.06;  // edge along x [m]
  double E = 3800, nu = 0.15;
  double aspect = 1;     // edge along x over the others'
  double strain = 1e-6;  // F / (E A)
  std::array<int, 3> cells{2, 2, 2};
  int elements = 40;  // of outlines
};

Scene VolumeScene(const Family& family, const Stretch& stretch);
Scene OutlineScene(const Family& family, const Stretch& stretch);
Scene MembraneScene(const Family& family, double radius, double thickness, double E, double nu);

// Counts of cases per family: accurate within their bound, flagged, refused with a reason, and
// WRONG.
std::map<std::string, std::map<std::string, int>>& Outcomes();
// Evaluates one case: `ask` returns the relative error and writes the worst validity to its
// argument. Exceptions of std::invalid_argument are refusals; any other fault is wrong.
void CheckCell(const std::string& family, const std::string& cell, double bound,
               const std::function<double(Validity* worst)>& ask);

// The same for one query of a family's model, which it builds.
using PressSpec = std::function<double(DeformationModel& model, Validity* worst)>;
void CheckBody(const Family& family, const std::string& axis, const std::string& value,
               const Scene& scene, const ObjectMesh& mesh, double bound, const PressSpec& ask);

// Pulls the far face with F = strain E A and compares its mean displacement.
void CheckVolumeStretch(const Family& family, const Stretch& stretch, const std::string& axis,
                        const std::string& value);
void CheckOutlineStretch(const Family& family, const Stretch& stretch, const std::string& axis,
                         const std::string& value);

// Queries the model with `contacts`; the first validity that is not kValid is kept in `worst`.
// Throws std::invalid_argument for a failure with a reason, and std::runtime_error for a failure
// without one or a value that is not finite.
std::vector<ContactResponse> Query(DeformationModel& model, const std::vector<Contact>& contacts,
                                   Validity* worst);

}  // namespace palpate::extremes

// Bodies whose answer is known in closed form, and how an answer is judged against it.
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

// A model of the family, as a scene asks for it, and what may be demanded of it.
struct Family {
  std::string name;                        // for people
  std::string kind;                        // model.kind
  std::function<void(ModelOptions*)> set;  // the other options; may be empty
  double bound = 1e-6;  // relative error of a uniform stretch that the method allows
};

// Boxes under uniform tension along x, on rollers at x = 0, y = 0 and z = 0: u_x(L) = F L / (E A)
// for any Poisson ratio, exactly so for every element that passes the patch test.
const std::vector<Family>& Volumes();
// Rectangles under the same, plane stress.
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

// How many cells were accurate within their bound, flagged, refused with a reason, and WRONG.
std::map<std::string, int>& Outcomes();

// Runs one cell: builds the model, lets `ask` question it, and judges. `ask` returns the relative
// error and leaves the worst validity in its second argument. Exceptions of std::invalid_argument
// are refusals; any other fault is wrong.
using PressSpec = std::function<double(DeformationModel& model, Validity* worst)>;
void CheckBody(const Family& family, const std::string& axis, const std::string& value,
               const Scene& scene, const ObjectMesh& mesh, double bound, const PressSpec& ask);

// Pulls the far face with F = strain E A and compares its mean displacement.
void CheckVolumeStretch(const Family& family, const Stretch& stretch, const std::string& axis,
                        const std::string& value);
void CheckOutlineStretch(const Family& family, const Stretch& stretch, const std::string& axis,
                         const std::string& value);

// Answers `contacts`; the first validity that is not kValid stays in `worst`. Throws: a failure
// with its reason as std::invalid_argument, one without and what is not finite as
// std::runtime_error.
std::vector<ContactResponse> Query(DeformationModel& model, const std::vector<Contact>& contacts,
                                   Validity* worst);

}  // namespace palpate::extremes

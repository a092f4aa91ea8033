#include "slave/simulator/camera/solutions_ahead.h"

#include <cmath>
#include <cstddef>
#include <exception>
#include <utility>

#include "slave/reference/solid/pressed_block.h"

namespace palpate::simulation {
namespace {

// Places closer than this part of the larger side share a solution (0.02 mm on the 88 mm block):
// there the stiffness changes by less than 1e-4.
constexpr double kRaster = 0.02 / 88;
// Places on solids that are closer than this part of the tool's width share a solution, because
// solutions take seconds. The stiffness beside a corner changes by less than 5e-3.
constexpr double kSolidRaster = 1.0 / 16;
constexpr std::size_t kMaxKept = 8;

}  // namespace

SolutionsAhead::SolutionsAhead(const TrueBody& body, double poisson_ratio, Plane plane,
                               const Tool& tool, bool tilts, double thickness)
    : body_(body),
      poisson_ratio_(poisson_ratio),
      plane_(plane),
      tool_(tool),
      tilts_(tilts),
      thickness_(tool.IsNarrowerThan(thickness) ? thickness : 0),
      raster_(thickness_ > 0 ? kSolidRaster * tool.width : kRaster * body.larger_side()),
      contacts_(kMaxKept) {}

std::shared_ptr<SolutionsAhead::Contact> SolutionsAhead::Wanted(const BoundaryPlace& place) {
  const long multiple = std::lround(place.s / raster_);
  return contacts_.Want(
      [&](const Contact& c) { return c.loop == place.loop && c.multiple == multiple; },
      [&] { return std::make_shared<Contact>(ContactAhead{}, *this, place.loop, multiple); });
}

std::shared_ptr<const PatchSolution> SolutionsAhead::Await(const BoundaryPlace& place) {
  const auto contact = Wanted(place);
  return contacts_.Await([&] { return contact->complete; }, [&] { return contact->solution; });
}

std::shared_ptr<const PatchSolution> SolutionsAhead::Contact::Solve() const noexcept {
  try {
    const auto place = of.body_.PlaceAt(loop, static_cast<double>(multiple) * of.raster_);
    if (of.thickness_ > 0) {
      return std::make_shared<PatchSolution>(
          SolveBlock(of.body_, of.poisson_ratio_, of.thickness_, place, of.tool_));
    }
    return std::make_shared<PatchSolution>(
        of.tilts_ || of.tool_.radius > 0
            ? SolveUnderRound(of.body_, of.poisson_ratio_, of.plane_, place, of.tool_)
            : SolvePatch(of.body_, of.poisson_ratio_, of.plane_, place, of.tool_.width));
  } catch (const std::exception&) {
    return nullptr;  // the failure is stored, so that no caller waits again
  }
}

void SolutionsAhead::Contact::Add(std::shared_ptr<const PatchSolution> solved) {
  solution = std::move(solved);
  complete = true;
}

}  // namespace palpate::simulation

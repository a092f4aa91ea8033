#include "slave/site/camera/tagged_outline.h"

#include <algorithm>
#include <cmath>

namespace palpate::site {

TaggedOutline Divide(const TrueBody& body, int loop, std::pair<double, double> patch, double unit) {
  TaggedOutline outline;
  const double length = body.loop_length(loop), tolerance = 1e-9 * body.larger_side();
  const auto shifted = [&](double s, double after) {  // s + k length, the first one behind `after`
    return s + length * std::ceil((after - s) / length);
  };
  std::size_t loop_start = 0;
  const auto& edges = body.edges();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const TrueBody::Edge& e = edges[i];
    std::vector<double> cuts{0};
    for (const double end : {patch.first, patch.second}) {
      const double at = shifted(end, e.s) - e.s;
      if (e.loop == loop && at > tolerance && at < e.length() - tolerance) cuts.push_back(at);
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.push_back(e.length());
    const int held = (e.held_x ? kHeldX : 0) | (e.held_y ? kHeldY : 0);
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const double middle = e.s + 0.5 * (cuts[c] + cuts[c + 1]);
      const bool touched = e.loop == loop && shifted(middle, patch.first) < patch.second;
      const int number = static_cast<int>(outline.points.size());
      outline.points.push_back((e.a + cuts[c] / e.length() * (e.b - e.a)) / unit);
      outline.segments.push_back({number, number + 1, held | (touched ? kPatch : 0)});
    }
    if (i + 1 == edges.size() || edges[i + 1].loop != e.loop) {
      outline.segments.back().b = static_cast<int>(loop_start);
      loop_start = outline.points.size();
    }
  }
  return outline;
}

}  // namespace palpate::site

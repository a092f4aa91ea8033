#include "slave/scene/sections.h"

namespace palpate {

std::vector<Eigen::Vector3d> ReadStudyContacts(Section& scene) {
  constexpr std::size_t kMost = 100;
  constexpr std::string_view kAccepted = "a list of 1 to 100 places [x, y, z] on the object";
  Section study = scene.Open("study");
  std::vector<Eigen::Vector3d> places;
  if (!study.Has("contacts")) return places;
  Section list = study.OpenList("contacts");
  if (!list.present()) return places;
  if (list.size() == 0 || list.size() > kMost) study.Refuse("contacts", kAccepted);
  for (std::size_t i = 0; i < list.size(); ++i) {
    places.push_back(
        list.Vector3(std::to_string(i), Any(Dimension::kLength), Eigen::Vector3d::Zero()));
  }
  return places;
}

}  // namespace palpate

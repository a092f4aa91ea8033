#include "slave/commands/solve/nodal_field_file.h"

namespace palpate {

NodalFieldFile::NodalFieldFile(std::filesystem::path file, DeformationModel& model, VtuGrid grid)
    : file_(std::move(file)), model_(model), grid_(std::move(grid)) {}

void NodalFieldFile::AddCase(const std::string& name) {
  model_.BoundaryDisplacement(&cases_.emplace_back(name, std::vector<Eigen::Vector3d>()).second);
}

bool NodalFieldFile::Write() const {
  VtuGrid grid = grid_;
  for (const auto& [name, displacement_O] : cases_) {
    PointArray array{CaseArrayName("displacement", name, cases_.size()), 3, {}, {}};
    for (const auto& u : displacement_O)
      array.values.insert(array.values.end(), u.begin(), u.end());
    grid.arrays.push_back(std::move(array));
  }
  return WriteVtu(file_, grid, VtuForm::kAppended);
}

}  // namespace palpate

#include "slave/commands/field_file.h"

#include <stdexcept>

#include "slave/commands/planar_field_file.h"

namespace palpate {

std::unique_ptr<FieldFile> MakeFieldFile(const std::filesystem::path& file, DeformationModel& model,
                                         const ObjectMesh& /*mesh*/) {
  if (const auto* planar = dynamic_cast<const Bem2dModel*>(&model)) {
    return std::make_unique<PlanarFieldFile>(file, *planar);
  }
  throw std::invalid_argument("--field: accepted with planar objects only");
}

}  // namespace palpate

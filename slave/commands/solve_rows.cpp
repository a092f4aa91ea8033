#include "slave/commands/solve_rows.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <string_view>

#include "shared/mesh/boundary_patch.h"
#include "slave/commands/csv_table.h"

namespace palpate {
namespace {

using Axes = std::array<std::string_view, 3>;

constexpr Axes kPlace{"x", "y", "z"};
constexpr Axes kMoved{"dx", "dy", "dz"};
constexpr Axes kLoaded{"fx", "fy", "fz"};

CsvTable ReadTable(const std::filesystem::path& file, const Axes& value) {
  const std::array<CsvTable::Column, 8> columns{{{"case"},
                                                 {kPlace[0]},
                                                 {kPlace[1]},
                                                 {kPlace[2], false},
                                                 {value[0]},
                                                 {value[1]},
                                                 {value[2], false},
                                                 {"width", false}}};
  return {file, columns};
}

Eigen::Vector3d PlanarVector(const CsvTable& table, std::size_t row, const Axes& axes) {
  const Eigen::Vector3d v(table.Number(row, axes[0]), table.Number(row, axes[1]),
                          table.Number(row, axes[2]));
  if (v.z() != 0) throw table.Refusal(row, axes[2], "0 on a planar object");
  return v;
}

int ElementThere(const CsvTable& table, std::size_t row, const BoundaryMesh& mesh,
                 const Eigen::Vector2d& place) {
  const int element = FindElement(mesh, place);
  const auto& found = mesh.elements[static_cast<std::size_t>(element)];
  const double distance = DistanceTo(found, place);
  if (distance <= 0.5 * found.length()) return element;
  std::array<char, 160> accepted{};
  std::snprintf(accepted.data(), accepted.size(),
                "a place on the boundary; this one, y = %.6g, lies %.3g m from it, more than half "
                "an element (%.3g m)",
                place.y(), distance, 0.5 * found.length());
  throw table.Refusal(row, "x", accepted.data());
}

std::string Digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

void WriteVector(std::ofstream* stream, const Eigen::Vector3d& v, bool known) {
  for (const double component : v) *stream << ',' << (known ? Digits(component) : "");
}

}  // namespace

void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const BoundaryMesh& mesh,
                std::vector<SolveRow>* rows) {
  const bool moved = kind == Contact::Kind::kDisplacement;
  const Axes& value = moved ? kMoved : kLoaded;
  const CsvTable table = ReadTable(file, value);
  for (std::size_t i = 0; i < table.size(); ++i) {
    SolveRow row;
    row.case_name = table.Text(i, "case");
    row.contact.kind = kind;
    row.contact.p_O = PlanarVector(table, i, kPlace);
    row.contact.element = ElementThere(table, i, mesh, row.contact.p_O.head<2>());
    row.contact.width = table.Number(i, "width");
    if (row.contact.width < 0) throw table.Refusal(i, "width", "a width >= 0 [m]");
    row.contact.value_O = PlanarVector(table, i, value);
    rows->push_back(std::move(row));
  }
}

bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows) {
  std::ofstream stream(file);
  stream << "case,x,y,z,dx,dy,dz,fx,fy,fz,solve_us,validity\n";
  for (const auto& row : rows) {
    const bool known = row.response.validity != Validity::kFailed;
    const bool moved = row.contact.kind == Contact::Kind::kDisplacement;
    stream << row.case_name;
    WriteVector(&stream, row.contact.p_O, true);
    WriteVector(&stream, moved ? row.contact.value_O : row.response.displacement_O, known || moved);
    WriteVector(&stream, moved ? row.response.force_O : row.contact.value_O, known || !moved);
    stream << ',' << Digits(row.solve_us) << ',' << ToString(row.response.validity) << '\n';
  }
  stream.flush();
  return stream.good();
}

}  // namespace palpate

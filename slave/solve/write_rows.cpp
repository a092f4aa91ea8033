#include "slave/solve/write_rows.h"

#include <algorithm>
#include <fstream>
#include <string>

#include "shared/text/text.h"
#include "shared/wire/enum_names.h"

namespace palpate {
namespace {

// Returns a name as a cell, in quotes if it contains a separator or a quote.
std::string InQuotes(const std::string& name) {
  if (name.find_first_of(",;\"") == std::string::npos) return name;
  std::string cell = "\"";
  for (const char c : name) cell.append(c == '"' ? 2 : 1, c);
  return cell + '"';
}

void WriteVector(std::ofstream* stream, const Eigen::Vector3d& v, bool known) {
  for (const double component : v) *stream << ',' << (known ? Formatted("%.17g", component) : "");
}

}  // namespace

bool WriteRows(const std::filesystem::path& file, const std::vector<SolveRow>& rows, bool moments) {
  const bool in_time = !rows.empty() && rows.front().t.has_value();
  const bool errors =
      std::ranges::any_of(rows, [&](const SolveRow& row) { return ErrorOf(row.response) > 0; });
  const bool is_round = std::ranges::any_of(rows, IsPressedRound);
  std::ofstream stream(file);
  stream << "case,x,y,z,dx,dy,dz,fx,fy,fz,solve_us,validity" << (in_time ? ",t" : "")
         << (moments ? ",mx,my,mz" : "") << (errors ? ",error" : "") << ",width"
         << (is_round ? ",radius\n" : "\n");
  for (const auto& row : rows) {
    const bool known = row.response.validity != Validity::kFailed;
    const bool moved = row.contact.kind == Contact::Kind::kDisplacement;
    stream << InQuotes(row.case_name);
    WriteVector(&stream, row.contact.p_O, true);
    WriteVector(&stream, moved ? row.contact.prescribed_O : row.response.displacement_O,
                known || moved);
    WriteVector(&stream, moved ? row.response.force_O : row.contact.prescribed_O, known || !moved);
    stream << ',' << Formatted("%.17g", row.solve_us) << ',' << ToString(row.response.validity);
    if (in_time) stream << ',' << Formatted("%.17g", *row.t);
    const auto& moment = row.response.moment_O;
    if (moments) WriteVector(&stream, moment.value_or(Eigen::Vector3d::Zero()), moment.has_value());
    const double error = ErrorOf(row.response);
    if (errors) stream << ',' << (known && error > 0 ? Formatted("%.17g", error) : "");
    const bool is_flat = !moved || row.tool.shape == Tool::Shape::kFlat;
    stream << ',' << Formatted("%.17g", is_flat ? row.contact.width : 0);
    if (is_round) stream << ',' << Formatted("%.17g", IsPressedRound(row) ? row.tool.radius : 0);
    stream << '\n';
  }
  stream.flush();
  return stream.good();
}

}  // namespace palpate

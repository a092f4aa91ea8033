#include "slave/solve/solve_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <string_view>

#include "shared/text/csv.h"
#include "slave/mechanics/factory/make_model.h"

namespace palpate {
namespace {

using Axes = std::array<std::string_view, 3>;

constexpr Axes kPlace{"x", "y", "z"};
constexpr Axes kMoved{"dx", "dy", "dz"};
constexpr Axes kLoaded{"fx", "fy", "fz"};

// Opens a table with the columns of contacts or loads, and optionally those of their answers from
// WriteRows.
CsvTable OpenTable(const std::filesystem::path& file, bool moved, bool planar,
                   const RowRules& rules) {
  const auto length = Quantity::kLength, force = Quantity::kForce;
  const Axes &value = moved ? kMoved : kLoaded, &answer = moved ? kLoaded : kMoved;
  std::vector<CsvTable::Column> columns{{"case"}};
  const auto add = [&](const Axes& axes, bool required, Quantity quantity) {
    for (const std::string_view axis : axes) {
      columns.push_back({axis, required && !(planar && axis == axes[2]), quantity});
    }
  };
  add(kPlace, true, length);
  add(value, moved || !rules.has_free_points, moved ? length : force);
  add(answer, rules.needs_answers, moved ? force : length);
  columns.push_back({"width", false, length});
  if (planar && moved) columns.push_back({"depth", false, length});
  if (rules.dynamic) columns.push_back({"t", false, Quantity::kTime});
  if (!rules.dynamic && moved) columns.push_back({"radius", false, length});
  for (const std::string_view name : {"solve_us", "validity", "mx", "my", "mz", "error"}) {
    columns.push_back({name, false});
  }
  return CsvTable(file, std::move(columns));
}

Eigen::Vector3d Vector(const CsvTable& table, const Axes& axes) {
  return {table.Number(axes[0]), table.Number(axes[1]), table.Number(axes[2])};
}

// Returns the vector; NaN for missing numbers.
Eigen::Vector3d VectorOrNone(const CsvTable& table, const Axes& axes) {
  Eigen::Vector3d v = Vector(table, axes);
  for (const int axis : {0, 1, 2}) {
    if (table.IsAbsent(axes[static_cast<std::size_t>(axis)])) v[axis] = std::nan("");
  }
  return v;
}

// Refuses other components: a planar object moves in its plane, a membrane along its normal.
void RefuseOtherAxes(const RowValues& values, const Axes& axes, const ObjectMesh& mesh,
                     const RefuseColumn& refuse) {
  if (std::holds_alternative<BoundaryMesh>(mesh) && values.prescribed_O.z() != 0) {
    refuse(axes[2], "0 on a planar object");
  }
  if (!std::holds_alternative<MembraneDisc>(mesh)) return;
  for (const int axis : {0, 1}) {
    const auto i = static_cast<std::size_t>(axis);
    if (values.prescribed_O[axis] != 0) refuse(axes[i], "0 on a membrane");
  }
}

// Sets the row's tool: that of the scene, changed by the columns. `radius` makes it round, or flat
// if 0; `width` is that of a flat one, `depth` its extent through the thickness of a planar object.
void SetTool(const RowValues& values, const RowRules& rules, double largest,
             const RefuseColumn& refuse, SolveRow* row) {
  const bool moved = row->contact.kind == Contact::Kind::kDisplacement;
  row->tool = rules.tool;
  if (values.radius) {
    const double radius = *values.radius;
    if (radius < 0 || radius > 10 * largest) {
      refuse("radius", Formatted("0 to %.4g m, ten times the object", 10 * largest));
    }
    if (rules.shaped && radius != rules.tool.radius) {
      refuse("radius", Formatted("%.9g m, that of the scene's tool, with this kind of model",
                                 rules.tool.radius));
    }
    if (!rules.shaped) row->tool.shape = radius > 0 ? Tool::Shape::kRound : Tool::Shape::kFlat;
    row->tool.radius = radius;
  }
  const bool is_flat = !moved || row->tool.shape == Tool::Shape::kFlat;
  const double width = values.width.value_or(rules.tool.width);
  if (width < 0 || width > largest) {
    refuse("width", Formatted("0 to %.4g m, the size of the object", largest));
  }
  row->contact.width = is_flat ? width : rules.tool.width;
  const bool has_tool = rules.tool.shape != Tool::Shape::kFlat || rules.tool.width > 0;
  row->contact.is_rigid = moved && has_tool && row->tool.IsRigidFace();
  if (values.depth) row->tool.depth = *values.depth;
  if (row->tool.depth && !(*row->tool.depth > 0)) refuse("depth", "a length > 0");
  if (row->tool.shape == Tool::Shape::kFlat) row->tool.width = width;
  if (!is_flat && values.width && width > 0) {
    refuse("width",
           "none under a round tool, a capsule or a rectangle, whose contact is the tool's; radius "
           "0 is "
           "a flat contact");
  }
}

}  // namespace

RowRules RulesOf(const Scene& scene) {
  return {.tool = scene.tool.value_or(Tool{}),
          .shaped = ShapesTool(scene),
          .dynamic = MovesInTime(scene)};
}

RowReader::RowReader(const ObjectMesh& mesh, const RowRules& rules)
    : mesh_(mesh), rules_(rules), surface_(mesh), largest_(SizeOf(mesh)) {}

SolveRow RowReader::Read(const RowValues& values, Contact::Kind kind,
                         const RefuseColumn& refuse) const {
  SolveRow row;
  row.contact.kind = kind;
  row.contact.p_O = values.p_O;
  if (std::holds_alternative<BoundaryMesh>(mesh_) && values.p_O.z() != 0) {
    refuse("z", "0 on a planar object");
  }
  std::string accepted;
  const auto distance = surface_.Distance(values.p_O, &accepted);
  if (!distance) refuse("x", accepted);
  row.off_surface = distance.value_or(0);
  SetTool(values, rules_, largest_, refuse, &row);
  row.contact.prescribed_O = values.prescribed_O;
  const bool moved = kind == Contact::Kind::kDisplacement;
  RefuseOtherAxes(values, moved ? kMoved : kLoaded, mesh_, refuse);
  return row;
}

void AppendRows(const std::filesystem::path& file, Contact::Kind kind, const ObjectMesh& mesh,
                const RowRules& rules, std::vector<SolveRow>* rows) {
  const bool moved = kind == Contact::Kind::kDisplacement;
  CsvTable table = OpenTable(file, moved, std::holds_alternative<BoundaryMesh>(mesh), rules);
  const RowReader reader(mesh, rules);
  const auto refuse = [&](std::string_view column, const std::string& accepted) {
    table.Refuse(column, accepted);
  };
  const auto value_of = [&](std::string_view column) {
    return table.IsAbsent(column) ? std::nullopt : std::optional(table.Number(column));
  };
  while (table.Next()) {
    const RowValues values{.p_O = Vector(table, kPlace),
                           .prescribed_O = Vector(table, moved ? kMoved : kLoaded),
                           .width = value_of("width"),
                           .radius = value_of("radius"),
                           .depth = value_of("depth")};
    SolveRow row = reader.Read(values, kind, refuse);
    row.case_name = table.Text("case");
    row.known_O = VectorOrNone(table, moved ? kLoaded : kMoved);
    if (table.Has("t")) row.t = table.Number("t");
    if (row.t && *row.t < 0) table.Refuse("t", "a time >= 0 [s]");
    rows->push_back(std::move(row));
  }
}

void RequireAlone(const std::vector<SolveRow>& rows) {
  std::map<std::string_view, int> rows_of;
  for (const SolveRow& row : rows) ++rows_of[row.case_name];
  for (const SolveRow& row : rows) {
    if (IsPressedRound(row) && rows_of[row.case_name] > 1) {
      throw InputError("solve: case " + row.case_name +
                       ": a round tool together with other rows: expected a separate case, or "
                       "--independent");
    }
  }
}

std::string WidthRemark(const Scene& scene, const std::vector<SolveRow>& rows) {
  const auto points = std::ranges::count_if(
      rows, [](const SolveRow& row) { return row.contact.width == 0 && row.tool.radius == 0; });
  if (points == 0 || std::holds_alternative<MembraneGeometry>(scene.object.geometry)) return {};
  return Formatted(
      "%ld of %zu rows have no width%s: a contact at a point has no limit under refinement, its "
      "force depends on the mesh",
      static_cast<long>(points), rows.size(), scene.tool ? "" : " and the scene has no tool");
}

std::string PlaceRemark(const ObjectMesh& mesh, const std::vector<SolveRow>& rows) {
  constexpr double kNear = 0.01;  // of the object's size
  const double near = kNear * SizeOf(mesh);
  const auto is_off = [&](const SolveRow& row) { return row.off_surface > near; };
  const auto count = std::ranges::count_if(rows, is_off);
  if (count == 0) return {};
  const SolveRow& farthest = *std::ranges::max_element(rows, {}, &SolveRow::off_surface);
  const Eigen::Vector3d& p = farthest.contact.p_O;
  return Formatted(
      "%ld of %zu rows lie off the surface, up to %.3g m (case %s at %.6g, %.6g, %.6g): they act "
      "at the nearest place of it",
      static_cast<long>(count), rows.size(), farthest.off_surface, farthest.case_name.c_str(),
      p.x(), p.y(), p.z());
}

std::vector<std::string> FlagRemarks(const std::vector<SolveRow>& rows) {
  struct FlagCount {
    std::size_t first = 0, count = 0;
  };
  std::map<std::string_view, FlagCount> by_reason;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].response.validity != Validity::kExtrapolated) continue;
    FlagCount& flagged = by_reason[ReasonOf(rows[i])];
    if (flagged.count++ == 0) flagged.first = i;
  }
  std::vector<std::string> remarks;
  for (const auto& [reason, flagged] : by_reason) {
    const SolveRow& row = rows[flagged.first];
    const Eigen::Vector3d& p = row.contact.p_O;
    remarks.push_back(Formatted(
        "%zu of %zu rows are extrapolated, first row %zu (case %s at %.6g, %.6g, %.6g): %.*s",
        flagged.count, rows.size(), flagged.first + 1, row.case_name.c_str(), p.x(), p.y(), p.z(),
        static_cast<int>(reason.size()), reason.data()));
  }
  return remarks;
}

PlaceHistory::PlaceHistory(const SolveRow& first) : contact_(first.contact) {
  Add(first);
}

bool PlaceHistory::Takes(const SolveRow& row) const {
  return row.contact.kind == contact_.kind && row.contact.p_O == contact_.p_O &&
         row.contact.width == contact_.width;
}

void PlaceHistory::Add(const SolveRow& row) {
  const double t = row.t.value_or(0);
  const auto later =
      std::ranges::upper_bound(values_, t, {}, [](const auto& v) { return v.first; });
  values_.emplace(later, t, row.contact.prescribed_O);
}

Contact PlaceHistory::At(double t) const {
  Contact contact = contact_;
  const auto after =
      std::ranges::upper_bound(values_, t, {}, [](const auto& v) { return v.first; });
  if (after == values_.begin()) {
    contact.prescribed_O = values_.front().second;
  } else if (after == values_.end()) {
    contact.prescribed_O = values_.back().second;
  } else {
    const auto& [t0, v0] = *std::prev(after);
    const auto& [t1, v1] = *after;
    contact.prescribed_O = v0 + (t - t0) / (t1 - t0) * (v1 - v0);
  }
  return contact;
}

std::vector<PlaceHistory> HistoriesOf(const std::vector<SolveRow>& rows,
                                      std::span<const std::size_t> of_case) {
  std::vector<PlaceHistory> histories;
  for (const std::size_t i : of_case) {
    const auto place =
        std::ranges::find_if(histories, [&](const PlaceHistory& h) { return h.Takes(rows[i]); });
    if (place == histories.end()) {
      histories.emplace_back(rows[i]);
    } else {
      place->Add(rows[i]);
    }
  }
  return histories;
}

}  // namespace palpate

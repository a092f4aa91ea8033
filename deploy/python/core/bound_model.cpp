#include "deploy/python/core/bound_model.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <variant>

#include "shared/text/text.h"
#include "slave/mechanics/factory/make_model.h"

namespace palpate::python {
namespace {

namespace py = pybind11;
using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

template <std::size_t kCorners>
std::vector<std::array<int, kCorners>> ElementsOf(const Integers& elements, py::ssize_t nodes) {
  std::vector<std::array<int, kCorners>> read(static_cast<std::size_t>(elements.shape(0)));
  const auto at = elements.unchecked<2>();
  for (py::ssize_t i = 0; i < at.shape(0); ++i) {
    for (py::ssize_t j = 0; j < at.shape(1); ++j) {
      const std::int64_t node = at(i, j);
      if (node < 0 || node >= nodes) {
        throw std::invalid_argument(
            Formatted("mesh: elements[%zd, %zd] = %lld: expected the number of a node, 0 to %zd", i,
                      j, static_cast<long long>(node), nodes - 1));
      }
      read[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = static_cast<int>(node);
    }
  }
  return read;
}

std::string ShapeOf(const py::array& array) {
  return py::str(array.attr("shape"));
}

void Set(py::array_t<double>* array, py::ssize_t i, py::ssize_t j, const Vector3d& v) {
  for (const int axis : {0, 1, 2}) *array->mutable_data(i, j, axis) = v[axis];
}

}  // namespace

std::shared_ptr<const GivenMesh> MeshOfArrays(const Numbers& nodes, const Integers& elements) {
  if (nodes.ndim() != 2 || nodes.shape(1) != 3) {
    throw std::invalid_argument("mesh: nodes of shape " + ShapeOf(nodes) + ": expected (n, 3) [m]");
  }
  if (elements.ndim() != 2 || (elements.shape(1) != 3 && elements.shape(1) != 4)) {
    throw std::invalid_argument("mesh: elements of shape " + ShapeOf(elements) +
                                ": expected (m, 4), tetrahedra, or (m, 3), triangles of a closed "
                                "surface");
  }
  const auto at = nodes.unchecked<2>();
  if (at.shape(0) > std::numeric_limits<int>::max()) {
    throw std::invalid_argument("mesh: expected at most 2^31 - 1 nodes");
  }
  std::vector<Vector3d> points(static_cast<std::size_t>(at.shape(0)));
  for (py::ssize_t i = 0; i < at.shape(0); ++i) {
    const Vector3d p(at(i, 0), at(i, 1), at(i, 2));
    if (!p.allFinite()) {
      throw std::invalid_argument(
          Formatted("mesh: nodes[%zd] = (%g, %g, %g): expected finite coordinates [m]", i, p.x(),
                    p.y(), p.z()));
    }
    points[static_cast<std::size_t>(i)] = p;
  }
  if (elements.shape(1) == 4) {
    return std::make_shared<const GivenMesh>(
        SolidMesh{std::move(points), ElementsOf<4>(elements, at.shape(0))});
  }
  return std::make_shared<const GivenMesh>(
      SurfaceMesh{std::move(points), ElementsOf<3>(elements, at.shape(0))});
}

BoundModel::BoundModel(Scene scene)
    : scene_(std::move(scene)), mesh_(MeshObject(scene_, std::nullopt)), rules_(RulesOf(scene_)) {
  if (rules_.dynamic) {
    throw std::invalid_argument(
        "model.time = dynamic or material.relaxation: expected a static model; palpate-slave solve "
        "computes histories");
  }
}

py::array_t<double> BoundModel::Nodes() const {
  const auto* solid = std::get_if<SolidMesh>(&mesh_);
  const std::size_t count = solid != nullptr ? solid->nodes.size() : 0;
  py::array_t<double> nodes({static_cast<py::ssize_t>(count), py::ssize_t{3}});
  for (std::size_t i = 0; i < count; ++i) {
    for (const int axis : {0, 1, 2}) {
      *nodes.mutable_data(static_cast<py::ssize_t>(i), axis) = solid->nodes[i][axis];
    }
  }
  return nodes;
}

void BoundModel::Fix(const Integers& nodes) {
  const auto alone = Alone();
  FixedNodes listed;
  for (py::ssize_t i = 0; i < nodes.size(); ++i) {
    const std::int64_t node = nodes.data()[i];
    const bool is_int = node >= 0 && node <= std::numeric_limits<int>::max();
    listed.nodes.push_back(is_int ? static_cast<int>(node) : -1);
  }
  if (listed.nodes.empty()) throw std::invalid_argument("fixed: no node: expected one or more");
  scene_.object.fixed.push_back({.where = std::move(listed)});
}

void BoundModel::Prepare() {
  const auto alone = Alone();
  Computed([&] {
    model_ = MakeModel(scene_, mesh_, &progress_);
    reader_.emplace(mesh_, rules_);
    solver_.emplace(scene_, mesh_, model_.get());
  });
}

py::dict BoundModel::Info() const {
  const auto alone = Alone();
  const ModelInfo& info = model_->info();
  py::dict dict;
  dict["kind"] = info.kind;
  dict["degrees_of_freedom"] = info.dof;
  dict["elements"] = info.elements;
  dict["precompute_s"] = info.precompute_s;
  dict["remark"] = info.remark;
  return dict;
}

py::tuple BoundModel::Solve(const Numbers& rows, bool are_loads, CaseStart next) {
  const auto alone = Alone();
  if (!solver_) throw std::logic_error("Solve before Prepare");
  if (rows.ndim() != 3 || rows.shape(2) != 6) {
    throw std::invalid_argument("contacts: expected the shape (cases, contacts, 6)");
  }
  const auto at = rows.unchecked<3>();
  const py::ssize_t cases = at.shape(0), contacts = at.shape(1);
  const char* name = are_loads ? "loads" : "contacts";
  if (cases * contacts == 0) {
    throw std::invalid_argument(std::string(name) + ": expected one contact or more");
  }
  if (!are_loads && !IsHeld(scene_.object)) {
    throw std::invalid_argument(
        "fixed = (missing): the body gives way as a whole: expected the part that does not move, "
        "such as fixed=lambda p: p[:, 2] < 1e-3 of a volume or {\"side\": \"bottom\"} of an "
        "outline");
  }
  rows_.clear();
  const double size = SizeOf(mesh_);
  const auto kind = are_loads ? Contact::Kind::kForce : Contact::Kind::kDisplacement;
  for (py::ssize_t i = 0; i < cases; ++i) {
    for (py::ssize_t j = 0; j < contacts; ++j) {
      const Vector3d p(at(i, j, 0), at(i, j, 1), at(i, j, 2)),
          v(at(i, j, 3), at(i, j, 4), at(i, j, 5));
      const auto refuse = [&](const std::string& accepted) {
        throw std::invalid_argument(
            Formatted("%s[%zd, %zd] = (%g, %g, %g, %g, %g, %g): expected %s", name, i, j, p.x(),
                      p.y(), p.z(), v.x(), v.y(), v.z(), accepted.c_str()));
      };
      if (!p.allFinite() || !v.allFinite()) refuse("finite numbers");
      rows_.push_back(reader_->Read(
          {.p_O = p, .prescribed_O = v}, kind,
          [&](std::string_view column, const std::string& accepted) {
            const bool is_tool = column == "width" || column == "radius" || column == "depth";
            refuse((is_tool ? "tool." + std::string(column) + " " : "") + accepted);
          }));
      if (!are_loads && v.norm() > size) {
        refuse(Formatted("a displacement up to the size of the body, %.4g m", size));
      }
      if (contacts > 1 && IsPressedRound(rows_.back()) && !rules_.shaped) {
        refuse("each contact of a round tool as a case of its own, shape (cases, 1, 6)");
      }
      rows_.back().case_name = std::to_string(i);
    }
  }
  py::array_t<double> force({cases, contacts, py::ssize_t{3}}),
      displacement({cases, contacts, py::ssize_t{3}}), error({cases, contacts});
  py::array_t<std::uint8_t> validity({cases, contacts});
  py::list why;
  Case one(static_cast<std::size_t>(contacts));
  for (py::ssize_t i = 0; i < cases; ++i) {
    const auto first = static_cast<std::size_t>(i * contacts);
    for (std::size_t k = 0; k < one.size(); ++k) one[k] = first + k;
    const CaseStart start = i == 0 ? CaseStart::kRest : next;
    Computed([&] { solver_->Solve(one, start, &rows_, &solution_); });
    for (py::ssize_t j = 0; j < contacts; ++j) {
      const SolveRow& row = rows_[first + static_cast<std::size_t>(j)];
      const ContactResponse& response = row.response;
      const bool known = response.validity != Validity::kFailed;
      const Vector3d unknown = Vector3d::Constant(kNone);
      const Vector3d& given = row.contact.prescribed_O;
      Set(&force, i, j, are_loads ? given : known ? response.force_O : unknown);
      Set(&displacement, i, j, !are_loads ? given : known ? response.displacement_O : unknown);
      const double estimated = ErrorOf(response);
      *error.mutable_data(i, j) = known && estimated > 0 ? estimated : kNone;
      *validity.mutable_data(i, j) = static_cast<std::uint8_t>(response.validity);
      if (!known) {
        why.append(solver_->failure());
      } else {
        why.append(response.validity == Validity::kValid ? std::string_view() : ReasonOf(row));
      }
    }
    RequireNoSignal();
  }
  return py::make_tuple(force, displacement, error, validity, why);
}

std::vector<std::string> BoundModel::Remarks() const {
  std::vector<std::string> remarks = RemarksOnObject(scene_);
  if (!scene_.tool && !std::holds_alternative<MembraneDisc>(mesh_)) {
    remarks.emplace_back(
        "tool = (missing): a contact acts at one place of the mesh, and its force depends on the "
        "mesh: expected a tool with a width or a radius");
  }
  return remarks;
}

}  // namespace palpate::python

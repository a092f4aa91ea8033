// The module palpate._core: the models, the comparison of forces and the fits of materials. The
// public functions, which check types, are in deploy/python/palpate.
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "deploy/python/core/bound_model.h"
#include "deploy/python/core/call.h"
#include "shared/program/program.h"
#include "shared/text/text.h"
#include "slave/identify/identify_material.h"
#include "slave/mechanics/factory/choose_model.h"
#include "slave/scene/scene_loader.h"
#include "slave/verify/force_table.h"
#include "slave/verify/report.h"

namespace palpate::python {
namespace {

namespace py = pybind11;
using Eigen::Vector3d;

// A mistake in a scene that Python wrote has no line.
std::string WordsOf(const SceneError& error) {
  std::string words;
  for (const SceneMistake& mistake : error.mistakes()) {
    words += words.empty() ? "" : "\n";
    if (!mistake.key.empty()) {
      words += mistake.key + " = " + (mistake.value.empty() ? "(missing)" : mistake.value);
    }
    if (mistake.key.empty()) words += mistake.message;
    if (!mistake.expected.empty()) words += ": expected " + mistake.expected;
  }
  return words;
}

std::unique_ptr<BoundModel> ModelOfText(const std::string& scene,
                                        const std::optional<Numbers>& nodes,
                                        const std::optional<Integers>& elements) {
  return Called([&] {
    std::shared_ptr<const GivenMesh> mesh;
    if (nodes && elements) mesh = MeshOfArrays(*nodes, *elements);
    try {
      return Computed([&] {
        return std::make_unique<BoundModel>(WithChosenModel(ParseScene(scene, std::move(mesh))));
      });
    } catch (const SceneError& error) {
      throw std::invalid_argument(WordsOf(error));
    }
  });
}

std::unique_ptr<BoundModel> ModelOfFile(const std::filesystem::path& scene,
                                        const std::vector<std::string>& overrides) {
  return Called([&] {
    return Computed([&] {
      return std::make_unique<BoundModel>(
          WithChosenModel(LoadScene(scene, overrides, SceneUse::kSolve)));
    });
  });
}

// (report as JSON, as text, whether it passes).
py::tuple ComparisonOf(const ForceTables& tables, const std::string& source) {
  const Comparisons comparisons = Computed([&] {
    Comparisons made;
    for (const auto& [finger, rows] : tables) made[finger] = CompareForces(rows);
    return made;
  });
  return py::make_tuple(ToJson("", source, comparisons), ToText(comparisons), Pass(comparisons));
}

Vector3d RowOf(const Numbers& array, py::ssize_t i) {
  const auto at = array.unchecked<2>();
  return {at(i, 0), at(i, 1), at(i, 2)};
}

// Arrays of n x 3 [N], and of n where given.
py::tuple CompareArrays(const Numbers& measured, const Numbers& estimated,
                        const std::optional<Numbers>& t, const std::optional<Numbers>& sigma,
                        const std::optional<Integers>& hold, const std::optional<Integers>& valid,
                        const std::string& source) {
  return Called([&] {
    std::vector<ForceRow> rows(static_cast<std::size_t>(measured.shape(0)));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto k = static_cast<py::ssize_t>(i);
      rows[i].measured = RowOf(measured, k);
      rows[i].estimated = RowOf(estimated, k);
      if (t) rows[i].t = t->at(k);
      if (sigma) rows[i].sigma = sigma->at(k);
      if (hold) rows[i].hold = static_cast<int>(hold->at(k));
      if (valid) rows[i].is_valid = valid->at(k) != 0;
    }
    return ComparisonOf({{"", rows}}, source);
  });
}

py::tuple CompareTable(const std::filesystem::path& file, const ForceColumns& columns) {
  return Called([&] {
    const ForceTables tables = Computed([&] { return ReadForces(file, columns); });
    return ComparisonOf(tables, file.filename().string());
  });
}

// (report as JSON, as text).
py::tuple Identified(const IdentifyRequest& request) {
  return Called([&] {
    SignalProgress progress;
    const IdentifyReport report = Computed([&] { return Identify(request, {}, &progress); });
    return py::make_tuple(ToJson(report), ToWords(report));
  });
}

void AddModel(py::module_* module) {
  py::class_<BoundModel>(*module, "Model")
      .def("nodes", &BoundModel::Nodes)
      .def("fix", &BoundModel::Fix)
      .def("prepare", [](BoundModel& model) { Called([&] { model.Prepare(); }); })
      .def("remarks", &BoundModel::Remarks)
      .def("place_remark", &BoundModel::PlaceRemark)
      .def("update_us", &BoundModel::update_us)
      .def("info", &BoundModel::Info)
      .def("solve", [](BoundModel& model, const Numbers& rows, bool are_loads, bool path) {
        const CaseStart next = path ? CaseStart::kLastCase : CaseStart::kRest;
        return Called([&] { return model.Solve(rows, are_loads, next); });
      });
  module->def("model_of_text", ModelOfText);
  module->def("model_of_file", ModelOfFile);
}

void AddVerify(py::module_* module) {
  py::class_<ForceColumns>(*module, "ForceColumns")
      .def(py::init<>())
      .def_readwrite("measured", &ForceColumns::measured)
      .def_readwrite("estimated", &ForceColumns::estimated)
      .def_readwrite("time", &ForceColumns::time)
      .def_readwrite("sigma", &ForceColumns::sigma)
      .def_readwrite("validity", &ForceColumns::validity)
      .def_readwrite("measured_unit", &ForceColumns::measured_unit)
      .def_readwrite("estimated_unit", &ForceColumns::estimated_unit)
      .def_readwrite("time_unit", &ForceColumns::time_unit);
  module->def("compare_arrays", CompareArrays);
  module->def("compare_table", CompareTable);
}

void AddIdentify(py::module_* module) {
  py::class_<IdentifyRequest>(*module, "IdentifyRequest")
      .def(py::init<>())
      .def_readwrite("data", &IdentifyRequest::data)
      .def_readwrite("scene", &IdentifyRequest::scene)
      .def_readwrite("overrides", &IdentifyRequest::overrides)
      .def_readwrite("area", &IdentifyRequest::area)
      .def_readwrite("diameter", &IdentifyRequest::diameter)
      .def_readwrite("height", &IdentifyRequest::height)
      .def_readwrite("ends", &IdentifyRequest::ends)
      .def_readwrite("stress_unit", &IdentifyRequest::stress_unit)
      .def_readwrite("x", &IdentifyRequest::x)
      .def_readwrite("y", &IdentifyRequest::y)
      .def_readwrite("smallest", &IdentifyRequest::from)
      .def_readwrite("largest", &IdentifyRequest::to)
      .def_readwrite("poisson_ratio", &IdentifyRequest::poisson_ratio)
      .def_readwrite("fit_poisson", &IdentifyRequest::fit_poisson)
      .def_readwrite("width", &IdentifyRequest::width);
  module->def("identify", Identified);
}

// pybind11 makes ValueError of std::invalid_argument.
void Translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const SceneError& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  } catch (const InputError& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
}

}  // namespace
}  // namespace palpate::python

PYBIND11_MODULE(_core, module) {
  palpate::blas::RestoreThreads();
  pybind11::register_exception_translator(palpate::python::Translate);
  module.attr("version") = palpate::Version();
  palpate::python::AddModel(&module);
  palpate::python::AddVerify(&module);
  palpate::python::AddIdentify(&module);
}

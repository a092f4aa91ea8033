// A prepared model as Python holds it: arrays of contacts in, arrays of answers out.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "deploy/python/core/call.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"
#include "slave/solve/case_solver.h"
#include "slave/solve/object_remarks.h"

namespace palpate::python {

// C-contiguous; what Python gives is converted.
using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;
using Integers =
    pybind11::array_t<std::int64_t, pybind11::array::c_style | pybind11::array::forcecast>;

// A mesh of nodes (n x 3) [m] and of elements: tetrahedra (m x 4) or triangles (m x 3) by their
// nodes from 0. Throws std::invalid_argument: another shape, a coordinate that is not finite, the
// number of a node that does not exist.
std::shared_ptr<const GivenMesh> MeshOfArrays(const Numbers& nodes, const Integers& elements);

// Threads of Python may call it at the same time; their calls wait for each other.
class BoundModel {
 public:
  // Meshes the object; the model is made by Prepare. Throws as MeshObject; std::invalid_argument: a
  // model that moves in time.
  explicit BoundModel(Scene scene);

  // The nodes of a volume, frame O (n x 3) [m]; of other objects none.
  [[nodiscard]] pybind11::array_t<double> Nodes() const;
  // Adds these nodes of a volume to what is fixed.
  void Fix(const Integers& nodes);
  // Throws as MakeModel.
  void Prepare();
  // See RemarksOnObject; and a missing tool.
  [[nodiscard]] std::vector<std::string> Remarks() const;
  [[nodiscard]] pybind11::dict Info() const;

  // `rows`: cases x contacts x 6, of each contact its place at rest [m], and its displacement [m]
  // or (`are_loads`) the force on the object [N]. The contacts of a case act together. The first
  // case starts from rest, the others as `next`. Returns (force, displacement, error, validity,
  // why): cases x contacts x 3 twice, cases x contacts twice, NaN where there is no number; and one
  // clause per contact. Throws std::invalid_argument naming the contact.
  pybind11::tuple Solve(const Numbers& rows, bool are_loads, CaseStart next);
  // The time that the model took for the last case [us].
  [[nodiscard]] double update_us() const {
    const auto alone = Alone();
    return rows_.empty() ? 0 : rows_.back().solve_us;
  }
  // See PlaceRemark, of the last answers.
  [[nodiscard]] std::string PlaceRemark() const {
    const auto alone = Alone();
    return palpate::PlaceRemark(mesh_, rows_);
  }

 private:
  // Waits without Python's lock, which the thread that computes may need.
  [[nodiscard]] std::unique_lock<std::mutex> Alone() const {
    return Computed([this] { return std::unique_lock(busy_); });
  }

  mutable std::mutex busy_;
  Scene scene_;
  ObjectMesh mesh_;
  RowRules rules_;
  SignalProgress progress_;  // of the model, as long as it lives
  std::unique_ptr<DeformationModel> model_;
  std::optional<RowReader> reader_;
  std::optional<CaseSolver> solver_;
  Solution solution_;
  std::vector<SolveRow> rows_;  // room
};

}  // namespace palpate::python

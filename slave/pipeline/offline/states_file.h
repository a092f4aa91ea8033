// What runs without an operator write row by row: states.csv.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "shared/state/slave_state.h"
#include "shared/state/validity.h"

namespace palpate {

// Frame S. What is not finite or not there is an empty field.
struct StateRow {
  double t = 0;  // [s]
  std::uint64_t sequence = 0;
  std::string finger;                    // empty: a camera's tool
  Eigen::Vector3d p_S_tip, p_S_contact;  // [m]
  std::optional<Eigen::Vector3d> force;  // of the object on the tool [N]
  double sigma = 0;                      // [N]; empty where the force is
  Validity validity = Validity::kFailed;
  std::optional<Eigen::Vector3d> true_force;  // [N]; only where the file has its columns
};

// What a camera's tool felt; `start`: of the run.
StateRow RowOf(const ContactEstimate& felt, Time start,
               const std::optional<Eigen::Vector3d>& true_force);

// Rows are flushed one by one, so that the file stays readable whatever happens.
class StatesFile {
 public:
  // Makes `folder` if missing and FOLDER/states.csv in it, removes an older summary.json. Throws
  // std::runtime_error: not writable.
  StatesFile(const std::filesystem::path& folder, bool has_truth);
  void Write(const StateRow& row);

 private:
  std::filesystem::path file_;
  bool has_truth_;
  std::ofstream stream_;
};

// Throws std::runtime_error naming the file.
void RequireWritten(bool written, const std::filesystem::path& file);

}  // namespace palpate

// Tables of tests as people and machines write them: CSV with a header that names columns and their
// units, below as many lines of remarks as there are.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/text/text.h"
#include "slave/identify/material_test.h"

namespace palpate::identify {

// Properties that the table does not contain.
struct Specimen {
  std::optional<double> area;         // of the loaded section at rest [m^2]
  std::optional<double> height;       // between the ends, or gauge length, at rest [m]
  std::optional<double> diameter;     // of a cylinder [m]
  bool bonded = false;                // the ends are bonded to the plates and cannot widen
  double poisson_ratio = 0.5;         // used only for the stiffening by bonded ends
  std::optional<double> stress_unit;  // of columns that name none [Pa]; nullopt: SI
  std::string abscissa, ordinate;     // columns; empty: found by their names
  // Only rows with a strain (or amount of shear) between these are used [-].
  double from = 0, to = 1e9;
};

struct TableRequest {
  std::string kind;  // uniaxial tension compression equibiaxial planar biaxial shear tensor
                     // relaxation; empty: tensor, where the columns are there
  std::filesystem::path file;
  double across = 0;  // of biaxial: second strain over the first; 0: column stretch_2
};

// Times, amounts and stresses of a relaxation test, as in the file.
struct RelaxationTable {
  std::string name;
  bool shear = false;                        // amounts of shear and shear stresses
  std::vector<double> time, strain, stress;  // [s], [-], [Pa]
  bool units_named = true;                   // of the stress
};

// Error for a table with too few rows, which may be skipped.
struct TooFewRows : InputError {
  using InputError::InputError;
};

// Throws InputError `file:line: ...` or `file: ...`: no header, a required column is missing, a
// cell that is not a number, an impossible deformation, fewer than four rows (TooFewRows);
// std::invalid_argument
// naming the option: forces and displacements need an area or length.
MaterialTest ReadTest(const TableRequest& request, const Specimen& specimen);
RelaxationTable ReadRelaxation(const TableRequest& request, const Specimen& specimen);

}  // namespace palpate::identify

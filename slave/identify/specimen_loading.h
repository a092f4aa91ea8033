// The course of a material test: its cycles, and its beginning, which may have slack, preload,
// offsets of load and travel, and a toe.
#pragma once

#include <cstddef>

#include "slave/identify/material_test.h"

namespace palpate::identify {

inline constexpr std::size_t kMinTestRows = 4;  // of a test that is used

// Strain of a row: stretch - 1, or amount of shear [-].
double StrainOf(const MaterialTest& test, const TestRow& row);
// The largest size of it in the test [-].
double LargestStrain(const MaterialTest& test);

// Keeps the first loading where loading and unloading differ (hysteresis) or later loadings differ
// (softening), and adds a remark with the moduli of the others. Cycles that agree stay.
void KeepFirstLoading(MaterialTest* test);

// Subtracts the travel of a first row without load. Adds a remark, also if the load of the first
// row fits neither its travel nor a preload: then the modulus may be wrong.
void TakeOffTravel(MaterialTest* test);

// Removes the part before the specimen is loaded: an offset or preload of the load, and slack,
// which are rows over which the load does not change. Contact begins where the line through the
// rows after the slack meets the initial load. Adds remarks.
void TakeOffBeginning(MaterialTest* test);

// Adds a remark if the test is softer at the beginning than later, and returns whether it did. A
// toe region looks like a stiffening material.
bool RemarkSoftBeginning(MaterialTest* test);

// Adds a remark if a tension stiffens from rest as compressions do, or a compression softens as
// tensions do.
void RemarkOppositeKind(MaterialTest* test);

}  // namespace palpate::identify

// What a unit force on the free surface of a held body does to every place of it: the Green's
// functions that contacts in 3D are answered with (James and Pai 2003; paper A, eqs. 5-7, in the
// form of a compliance: a surface that is free of traction in the reference problem needs no other
// block of E).
//
// Nondimensional: lengths by length_unit(), forces by E times its square.
#pragma once

#include <cstddef>

namespace palpate {

class Compliance {
 public:
  virtual ~Compliance() = default;
  Compliance() = default;
  Compliance(const Compliance&) = delete;
  Compliance& operator=(const Compliance&) = delete;

  // Places that can be touched: surface nodes (fem-green) or triangles (bem3d).
  [[nodiscard]] virtual int places() const = 0;
  // Betti: block(i, j) = block(j, i)^T to working precision. Then contacts are factorised by
  // Cholesky's method.
  [[nodiscard]] virtual bool symmetric() const = 0;
  // 9 numbers per place i: entry 3 c + r is the displacement along r at i by a unit force along c
  // at `place`. Columns may be computed when first asked for: milliseconds then, and memory;
  // nullptr never. The pointer stays good.
  virtual const double* Column(int place) = 0;
  // The column is there already: asking for it costs nothing.
  [[nodiscard]] virtual bool IsReady(int place) const = 0;
  [[nodiscard]] virtual double length_unit() const = 0;  // [m]
  [[nodiscard]] virtual std::size_t memory_bytes() const = 0;
};

}  // namespace palpate

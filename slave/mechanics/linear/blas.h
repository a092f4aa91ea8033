// Threads of OpenBLAS in a process that also computes for others, such as an interpreter.
#pragma once

namespace palpate::blas {

// OpenBLAS computes on one thread while an object of this class exists, on any thread, and then on
// as many as before. It does nothing with another BLAS.
class OneThread {
 public:
  OneThread() noexcept;
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;
};

// Restores the number of threads that the program had before this library set it to one.
void RestoreThreads() noexcept;

}  // namespace palpate::blas

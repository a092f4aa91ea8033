// Threads of OpenBLAS in a process that also computes for others, such as an interpreter.
#pragma once

namespace palpate::blas {

// OpenBLAS computes on one thread while this object exists, and then on as many as before. It does
// nothing with another BLAS. One object at a time.
class OneThread {
 public:
  OneThread() noexcept;
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

// Restores the number of threads that the program had before this library set it to one.
void RestoreThreads() noexcept;

}  // namespace palpate::blas

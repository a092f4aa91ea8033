// Limits OpenBLAS to one thread in every program that links this file.
#include "slave/mechanics/linear/blas.h"

#include <mutex>

// Functions of OpenBLAS with threads; null for other BLAS libraries.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int threads);
[[gnu::weak]] int openblas_get_num_threads();
[[gnu::weak]] int blas_thread_shutdown_();  // OpenBLAS calls this before a fork
}

namespace palpate::blas {
namespace {

int ThreadsNow() noexcept {
  return openblas_get_num_threads != nullptr ? openblas_get_num_threads() : 0;
}

void SetThreads(int threads) noexcept {
  if (openblas_set_num_threads != nullptr && threads > 0) openblas_set_num_threads(threads);
}

int threads_at_load = 0;

std::mutex users_mutex;  // guards the next two
int users = 0, threads_before = 0;

// Models are made and updated on several threads at the same time. Debian's single-threaded
// OpenBLAS allocates its work buffers without a lock, so two callers may share one: about once in a
// thousand runs a factorisation was wrong. The multi-threaded version has locks, and limited to one
// thread returns the same numbers; the threads that it starts when it is loaded would spin for 30
// ms each.
bool UseOneThread() {
  threads_at_load = ThreadsNow();
  SetThreads(1);
  if (blas_thread_shutdown_ != nullptr) blas_thread_shutdown_();
  return true;
}

}  // namespace

// True after the library was configured, before main. The linker keeps it (CMakeLists.txt).
extern const bool uses_one_thread;
const bool uses_one_thread = UseOneThread();

OneThread::OneThread() noexcept {
  const std::scoped_lock lock(users_mutex);
  if (users++ == 0) threads_before = ThreadsNow();
  SetThreads(1);
}

OneThread::~OneThread() {
  const std::scoped_lock lock(users_mutex);
  if (--users == 0) SetThreads(threads_before);
}

void RestoreThreads() noexcept {
  SetThreads(threads_at_load);
}

}  // namespace palpate::blas

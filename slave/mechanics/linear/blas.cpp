// Every program that links this computes on one thread in OpenBLAS.

// Where BLAS is OpenBLAS with threads; else they are null.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int threads);
[[gnu::weak]] int blas_thread_shutdown_();  // what it calls before a fork
}

namespace palpate::blas {
namespace {

// Models are made and updated on several threads at once. Debian's OpenBLAS without threads takes
// its work buffers without a lock, so that two callers may share one: about once in a thousand runs
// something was factorised to garbage. The one with threads has the locks, and with one thread the
// same numbers; those that it started when it was loaded would spin for 30 ms each.
bool UseOneThread() {
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  if (blas_thread_shutdown_ != nullptr) blas_thread_shutdown_();
  return true;
}

}  // namespace

// True after the library was configured, before main. The linker keeps it (CMakeLists.txt).
extern const bool uses_one_thread;
const bool uses_one_thread = UseOneThread();

}  // namespace palpate::blas
